// SPDX-License-Identifier: Apache-2.0
// Schedules the fit of a pyramid's texels: levels from the coarsest to the finest, and each level in steps whose texels
// are independent of one another (docs/contributing/ALGORITHMS.md, "Order"). A step of some rows is one launch of the
// EM kernels.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/formats/image/plane_store.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {

enum class FitMethod {
  kChoice,  // four normals, each given to a lobe: movmf_choose
  kTexels,  // every normal a sample, one work-item a texel: movmf_em_texels
  kBinned,  // movmf_binning, then movmf_em_texels
  kChunks,  // every normal a sample, chunks of them summed apart: movmf_em_chunks, movmf_em_mstep
};

struct LevelSchedule {
  int level;
  MultumMovmfFit fit;  // for the whole level at once; all but slot_count
  FitMethod method;
  FitOrder order;
  int refit_iterations;  // of each further pass; those of the first are in `fit`
  int step_count;        // of a pass
};

struct MipSchedule {
  bool weighted;                      // texels cover fractions of finest texels
  std::vector<LevelSchedule> levels;  // coarsest first, down to level 1 or MovmfSettings::first_level

  bool uses(FitMethod method) const;
};

/// Weight of the mixed widths of movmf_choose.cl, in units of MovmfSettings::alignment.
constexpr float kChoiceAlignment = 14.0f;
/// A texel of up to this many samples is summed by one work-item in one go; larger ones are binned, or summed in
/// chunks. By the sample count alone, so that summation order never depends on bands or devices. 1024: the packed
/// normals of a group still fit a core's cache, and rounding of a plain sum stays below 1e-6.
constexpr int kSamplesUnchunkedMax = 1024;
/// Cells along a side of the grid of a binned texel: fewer of texels of up to so many samples, which are many. Both
/// odd, so that the flat normals of a map that tilts both ways alike lie in the middle of a cell and not on an edge.
constexpr int kSamplesFewCellsMax = 4096;
constexpr int kCellSideFew = 31;
constexpr int kCellSide = 71;
/// Of shortened normals, with a grid a class of lengths: about twice as many cells in all.
constexpr int kCellSideFewShortened = 21;
constexpr int kCellSideShortened = 47;
/// Where settled texels stop, one of at most so many normals (level 1) runs kIterationsFewNormals iterations instead:
/// lobes find them at once and then creep, and stopping where they have all but stopped costs up to a fifth more error.
/// Softer starts, of kappa times kStartFactorFewNormals, are there sooner; centres gain by that, and a stronger
/// alignment passes the gain on to the points between them.
constexpr int kFewNormals = 4;
constexpr int kIterationsFewNormals = 7;
constexpr float kStartFactorFewNormals = 0.5f;
constexpr float kAlignmentFactorFewNormals = 1.2f;
/// Texels that cover fewer normals are not refined (movmf_refine.cl): their lobes follow their normals as it is, and
/// what refining gains at texel centres is lost between them (four-quarter map of 256, s = 100, level 1: 11.4 % midway
/// for 10.8, level 2: 12.6 for 12.5). Level 3 covers 64, and about as many where sides are no powers of two.
constexpr float kRefinedNormalsMin = 32.0f;
/// Samples that a chunk of EM sums, about.
constexpr int kSamplesPerChunk = 4096;

/// `weighted`: use the kernels that weigh samples even where whole texels are covered (the same result).
MipSchedule make_mip_schedule(int map_width, int map_height, const MovmfSettings& settings, bool weighted = false);

/// Facets that a shortened normal stands for when EM shares it out (movmf_em.clh). Error of the four-quarter map of 256
/// with a constant, a smooth and a noisy roughness at level 2: 10.7, 13.5 and 38.8 % with 1, 5.8, 9.1 and 26.0 with
/// 4, 6.3, 9.4 and 29.6 with 16.
constexpr float kCopiesShortened = 4.0f;
/// Changes the schedule for normals that a BRDF's width has shortened.
void make_shortened(MipSchedule& schedule);
/// The schedule of a map, whose normals tell whether they are shortened.
MipSchedule make_mip_schedule(const PlaneStore& normals, const MovmfSettings& settings, bool weighted = false);

/// The texels of step `step` in the rows [first_row, last_row) of a level, as places (row - window_first_row) * width +
/// column in a window. Rows may lie beyond the level's borders: then they are those of the level repeated.
std::vector<int> step_texels(const LevelSchedule& level, int step, int first_row, int last_row, int window_first_row);

/// The first finest row that row `row` of the level covers, and one past the last; rows may lie beyond the borders.
int first_covered_row(const MultumMovmfFit& fit, int row);
int last_covered_row(const MultumMovmfFit& fit, int row);

}  // namespace multum
