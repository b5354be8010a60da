// SPDX-License-Identifier: Apache-2.0
// Arguments of one launch of the EM kernels, which fits some texels ("slots") of one level. Valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_MOVMF_FIT_H
#define MULTUM_KERNELS_SHARED_MOVMF_FIT_H

// Texels are fitted in groups of this many slots: the width of the vector variant, and the unit of the packed layouts.
#define MULTUM_GROUP 16
// Work-items that fit one texel together, on devices that have enough of them (movmf_em_texels.cl, movmf_binning.cl).
#define MULTUM_TEAM 64

// Values of MovmfFit::order: which same-level neighbours are done when a texel is fitted.
#define MULTUM_ORDER_COLOUR 0    // four colours (x&1, y&1) in the order (0,0), (1,1), (1,0), (0,1)
#define MULTUM_ORDER_AGAIN 2     // a further pass: every neighbour is done, the texel's own lobes are the start
#define MULTUM_ORDER_SCANLINE 1  // rows from top to bottom, from left to right: Han et al. 2007, section 7

// Floats a lobe in the start buffer: one plane of MULTUM_GROUP lanes each.
#define MULTUM_START_MU 0         // 3 planes: direction, unit length
#define MULTUM_START_SHARPNESS 3  // kappa * log2(e)
#define MULTUM_START_LOG 4        // log2(a kappa / (1 - exp(-2 kappa)))
#define MULTUM_START_PRIOR 5      // 3 planes: C * sum over done neighbours k of a_k mu_k
#define MULTUM_START_CAP 8        // the texel's cap of kappa, known after the first E-step
#define MULTUM_START_PLANES 9

// The grid of a binned texel (movmf_binning.cl): normals along a side that axes are made from, bins of an axis,
// floats that describe an axis.
#define MULTUM_PROBE_SIDE 32
#define MULTUM_PROBE_COUNT (MULTUM_PROBE_SIDE * MULTUM_PROBE_SIDE)
#define MULTUM_AXIS_BINS 63
#define MULTUM_AXIS_FLOATS (MULTUM_AXIS_BINS + 3)
// Shortened normals have a grid for each class of lengths: those of one cell must be alike in it too.
#define MULTUM_LENGTH_CLASSES 4
#define MULTUM_CELL_SUMS 4         // of three values and of weights, whole numbers of 2^-30
#define MULTUM_CONDENSED_SAMPLE 4  // floats: three mean values and their weight

typedef struct MultumMovmfFit {
  int map_width;  // finest level, texels, at most 32768 a side
  int map_height;
  int width;  // this level
  int height;
  int parent_width;  // next coarser level; 0: none, the level's own lobes are the start
  int parent_height;
  int sample_columns;  // finest texels that a texel's samples span, the largest of the level (narrower ones: weight 0)
  int sample_rows;
  // Buffers hold windows of rows: window row 0 is row `first_row` of the level, rows wrap at its height (a map that
  // repeats goes on above its first row), and planes of lobes are width * window_rows apart. A texel's number in
  // texel_list is its place in the window.
  int first_row;
  int window_rows;
  int parent_first_row;
  int parent_window_rows;
  int map_first_row;
  int map_window_rows;  // sums take the rows, or chunks that begin, in [map_first_row, + map_window_rows)
  int slot_count;       // slots of this launch, a multiple of MULTUM_GROUP; texel_list holds -1 in unused ones
  int order;            // MULTUM_ORDER_*
  int periodic_x;       // not 0: beyond the border lies the other one, whose texels are neighbours too
  int periodic_y;
  int iteration_count;
  int sample_capacity;                  // samples of a texel, at most (movmf_em_texels.cl): of a binned one its cells
  int cell_side;                        // cells along a side of a binned texel's grid; 0: not binned
  int shortened;                        // not 0: normals are mean vectors of a BRDF's lobes, of lengths up to 1
  float extra_copies;                   // a sample counts as one and so many more facets when EM shares it out
  float convergence_tolerance_squared;  // a texel in which nothing moves by more is done; 0: run every iteration
  int chunk_rows;                       // rows a chunk sums (movmf_em_chunks.cl)
  int chunk_count;                      // chunks a texel
  float start_kappa_factor;             // kappa of a start is the parent's times this
  float start_amplitude_min;            // and its amplitude at least this
  float alignment;                      // C of the alignment prior, >= 0
  float kappa_cap;  // cap of kappa inside EM: kappa_cap + kappa_cap_slope * kappa of all the texel's normals
  float kappa_cap_slope;
  float total_weight_inverse;  // 1 / (finest texels that a texel covers)
} MultumMovmfFit;

#endif
