// SPDX-License-Identifier: Apache-2.0
// In which order the texels of a pyramid are fitted: levels from the coarsest to the finest, and each level in steps
// whose texels are independent of one another (docs/ALGORITHMS.md, "Order"). A step is one launch of the EM kernels.
#pragma once

#include <cstdint>
#include <vector>

#include "host/bake/bake_settings.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {

struct FitStep {
  int list_offset;  // in MipSchedule::texel_list
  int texel_count;  // texels fitted; the list is filled up with -1 to whole groups
};

struct LevelSchedule {
  int level;
  MultumMovmfFit fit;  // all but slot_count and list_offset
  bool chunked;        // fitted by movmf_em_chunks and movmf_em_mstep instead of movmf_em_texels
  std::vector<FitStep> steps;
  std::vector<int> texel_list;  // y * width + x, grouped by steps
};

struct MipSchedule {
  bool weighted;                      // texels cover fractions of finest texels
  std::vector<LevelSchedule> levels;  // coarsest first, down to level 1 or MovmfSettings::first_level
};

/// A texel of up to this many samples is summed by one work-item in one go; larger ones in chunks. By the sample count
/// alone, so that summation order never depends on tiles or devices. 1024: the packed normals of a group still fit a
/// core's cache, and rounding of a plain sum stays below 1e-6.
constexpr int kSamplesUnchunkedMax = 1024;
/// Samples a chunk sums, about.
constexpr int kSamplesPerChunk = 4096;

/// `weighted`: use the kernels that weigh samples even where whole texels are covered (the same result).
MipSchedule make_mip_schedule(int map_width, int map_height, const MovmfSettings& settings, bool weighted = false);

}  // namespace multum
