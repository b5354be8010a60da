// SPDX-License-Identifier: Apache-2.0
// The arguments of one launch of the EM kernels, which fits some texels ("slots") of one level. This file is valid
// OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_FIT_H
#define MULTUM_KERNELS_SHARED_MOVMF_FIT_H

// The number of slots per group. This is the width of the vector variant, and the unit of the packed layouts.
#define MULTUM_GROUP 16
// The number of work-items that fit one texel together, on devices with enough of them (movmf_em_texels.cl,
// movmf_binning.cl).
#define MULTUM_TEAM 64

// The values of MovmfFit::order, which determines the neighbours that are fitted before a texel ("done").
#define MULTUM_ORDER_COLOUR 0    // four colours (x&1, y&1) in the order (0,0), (1,1), (1,0), (0,1)
#define MULTUM_ORDER_AGAIN 2     // a further pass: all neighbours are done; EM starts from the texel's own lobes
#define MULTUM_ORDER_SCANLINE 1  // rows from top to bottom, each from left to right: Han et al. 2007, section 7

// The floats per lobe in the start buffer. Each is one plane of MULTUM_GROUP lanes.
#define MULTUM_START_MU 0         // 3 planes: direction, unit length
#define MULTUM_START_SHARPNESS 3  // kappa * log2(e)
#define MULTUM_START_LOG 4        // log2(a kappa / (1 - exp(-2 kappa)))
#define MULTUM_START_PRIOR 5      // 3 planes: C * sum over done neighbours k of a_k mu_k
#define MULTUM_START_CAP 8        // the texel's cap of kappa, known after the first E-step
#define MULTUM_START_PLANES 9

// The sizes for the grid of a binned texel (movmf_binning.cl). These are the probed normals along a side, the bins per
// axis, and the floats that describe an axis.
#define MULTUM_PROBE_SIDE 32
#define MULTUM_PROBE_COUNT (MULTUM_PROBE_SIDE * MULTUM_PROBE_SIDE)
#define MULTUM_AXIS_BINS 63
#define MULTUM_AXIS_FLOATS (MULTUM_AXIS_BINS + 3)
// Shortened normals have a grid for each class of lengths, so that the normals of one cell have similar lengths.
#define MULTUM_LENGTH_CLASSES 4
#define MULTUM_CELL_SUMS 4         // three values and the weight, as integers in units of 2^-30
#define MULTUM_CONDENSED_SAMPLE 4  // floats: three mean values and their weight

typedef struct MultumMovmfFit {
  int map_width;  // size of the finest level in texels, at most 32768 per side
  int map_height;
  int width;  // width of this level
  int height;
  int parent_width;  // width of the next coarser level; 0 if there is none, and EM then starts from the level's own
                     // lobes
  int parent_height;
  int sample_columns;  // width of the level's widest texel in finest texels (samples outside narrower texels weigh 0)
  int sample_rows;
  // Buffers hold windows of rows. Window row 0 is row `first_row` of the level. Rows wrap at the level's height, so a
  // map that repeats continues above its first row. Planes of lobes are width * window_rows apart. A texel's number in
  // texel_list is its index in the window.
  int first_row;
  int window_rows;
  int parent_first_row;
  int parent_window_rows;
  int map_first_row;
  int map_window_rows;  // rows of the window; sums use these rows, or the chunks that begin in them
  int slot_count;       // slots of this launch, a multiple of MULTUM_GROUP; texel_list holds -1 in unused ones
  int order;            // one of MULTUM_ORDER_*
  int periodic_x;       // if not 0, texels at opposite borders are neighbours
  int periodic_y;
  // If not 0, the map consists of copies below each other, and each has copy_height rows of this level. Texels of
  // different copies are not neighbours. Copies have sides that are powers of two.
  int copy_height;
  int iteration_count;
  int sample_capacity;                  // largest number of samples (movmf_em_texels.cl), or of cells, per texel
  int cell_side;                        // cells along a side of a binned texel's grid; 0 means not binned
  int shortened;                        // if not 0, normals are mean vectors of a BRDF's lobes, at most 1 long
  float extra_copies;                   // facets that a sample represents in the E-step, in addition to 1
  float convergence_tolerance_squared;  // texels that change less have converged; 0 runs every iteration
  int chunk_rows;                       // rows per chunk (movmf_em_chunks.cl)
  int chunk_count;                      // chunks per texel
  float start_kappa_factor;             // the start kappa is the parent's kappa times this
  float start_amplitude_min;            // least start amplitude
  float alignment;                      // C of the alignment prior, >= 0
  float kappa_cap;                      // cap of kappa inside EM: kappa_cap + kappa_cap_slope * (kappa of all normals)
  float kappa_cap_slope;
  float total_weight_inverse;  // 1 / (finest texels that a texel covers)
} MultumMovmfFit;

#endif
