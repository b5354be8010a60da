// SPDX-License-Identifier: Apache-2.0
// Schedules the fit of a pyramid's texels. Levels are fitted from the coarsest to the finest. Each level is fitted in
// steps, and the texels of a step are independent of each other (docs/contributing/ALGORITHMS.md, "Order"). For a range
// of rows, each step is one launch of the EM kernels.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/formats/image/plane_store.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {

enum class FitMethod {
  kChoice,  // each of the four normals is assigned to a lobe: movmf_choose
  kTexels,  // every normal is a sample, one work-item per texel: movmf_em_texels
  kBinned,  // movmf_binning, then movmf_em_texels
  kChunks,  // every normal is a sample, summed in chunks: movmf_em_chunks, movmf_em_mstep
};

struct LevelSchedule {
  int level;
  MultumMovmfFit fit;  // values for the whole level; slot_count is not set
  FitMethod method;
  FitOrder order;
  int refit_iterations;  // EM iterations in each further pass; `fit` has the number for the first pass
  int step_count;        // number of steps of a pass
};

struct MipSchedule {
  bool weighted;                      // true if texels cover fractions of finest texels
  std::vector<LevelSchedule> levels;  // coarsest first, down to level 1 or MovmfSettings::first_level

  bool uses(FitMethod method) const;
};

/// Weight of the mixed widths of movmf_choose.cl, in units of MovmfSettings::alignment.
constexpr float kChoiceAlignment = 14.0f;
/// One work-item sums a texel of up to this many samples. Larger texels are binned or summed in chunks. The choice
/// depends only on the sample count, so that the order of sums never depends on bands or devices. With a limit of 1024,
/// the packed normals of a group still fit into a core's cache, and the rounding error of a plain sum stays below 1e-6.
constexpr int kSamplesUnchunkedMax = 1024;
/// The number of cells per side of the grid of a binned texel. Texels with up to kSamplesFewCellsMax samples are
/// numerous, so their grids have fewer cells. Both numbers are odd. If the normals of a map tilt equally far in both
/// directions, flat normals are therefore in the middle of a cell and not on an edge.
constexpr int kSamplesFewCellsMax = 4096;
constexpr int kCellSideFew = 31;
constexpr int kCellSide = 71;
/// The number of cells per side for shortened normals. Such normals have one grid per class of lengths, and about twice
/// as many cells in total.
constexpr int kCellSideFewShortened = 21;
constexpr int kCellSideShortened = 47;
/// A texel of at most this many normals (level 1) runs kIterationsFewNormals iterations instead of stopping early. The
/// lobes of such a texel reach the normals quickly and then move slowly. If EM stopped as soon as they hardly move, the
/// error would increase by up to a fifth. If the start's kappa is multiplied by kStartFactorFewNormals, EM converges
/// sooner, and the error at centres decreases. With a stronger alignment, errors between centres also decrease.
constexpr int kFewNormals = 4;
constexpr int kIterationsFewNormals = 7;
constexpr float kStartFactorFewNormals = 0.5f;
constexpr float kAlignmentFactorFewNormals = 1.2f;
/// Texels that cover fewer normals are not refined (movmf_refine.cl). The lobes of such texels already follow their
/// normals. Refining reduces errors at texel centres, but increases them between centres. For example, on the
/// four-quarter map of 256 x 256 texels with s = 100, refining these texels would raise errors at midpoints from 10.8
/// to 11.4 % at level 1, and from 12.5 to 12.6 % at level 2. Texels of level 3 cover about 64 normals, or exactly 64 if
/// sides are powers of two.
constexpr float kRefinedNormalsMin = 32.0f;
/// Approximate number of samples per EM chunk.
constexpr int kSamplesPerChunk = 4096;

/// `weighted` selects the kernels that weigh samples, even if texels cover only whole finest texels. The result is the
/// same.
MipSchedule make_mip_schedule(int map_width, int map_height, const MovmfSettings& settings, bool weighted = false);

/// Number of facets that a shortened normal represents when EM divides it among lobes (movmf_em.clh). With 4 facets,
/// errors at level 2 of the four-quarter map of 256 x 256 texels were lowest: 5.8, 9.1 and 26.0 % for a constant, a
/// smooth and a noisy roughness. With 1 facet they were 10.7, 13.5 and 38.8 %, and with 16 facets they were 6.3, 9.4
/// and 29.6 %.
constexpr float kCopiesShortened = 4.0f;
/// Adapts the schedule to normals that are shortened according to a BRDF's width.
void make_shortened(MipSchedule& schedule);
/// Makes the schedule of a map. The map's planes state whether normals are shortened.
MipSchedule make_mip_schedule(const PlaneStore& normals, const MovmfSettings& settings, bool weighted = false);

/// Adapts the schedule of a map whose sides are equal powers of two to `count` copies of the map below each other. Each
/// copy is fitted as if it were alone.
void make_copies(MipSchedule& schedule, int count);

/// Lists the texels of step `step` in the rows [first_row, last_row) of a level, as positions (row - window_first_row)
/// * width + column in a window. Rows outside the level's borders belong to the repeated level.
std::vector<int> step_texels(const LevelSchedule& level, int step, int first_row, int last_row, int window_first_row);

/// Returns the range of finest rows that row `row` of the level covers, as the first row and one past the last row. The
/// rows may be outside the borders.
int first_covered_row(const MultumMovmfFit& fit, int row);
int last_covered_row(const MultumMovmfFit& fit, int row);

}  // namespace multum
