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

enum class FitMethod {
  kTexels,     // every normal a sample, one work-item a texel: movmf_em_texels
  kCondensed,  // movmf_condense, then movmf_em_texels
  kChunks,     // every normal a sample, chunks of them summed apart: movmf_em_chunks, movmf_em_mstep
};

struct LevelSchedule {
  int level;
  MultumMovmfFit fit;  // all but slot_count and list_offset
  FitMethod method;
  int iteration_count_again;  // of each further sweep; that of the first is in `fit`
  std::vector<FitStep> steps;
  std::vector<int> texel_list;  // y * width + x, grouped by steps
};

struct MipSchedule {
  bool weighted;                      // texels cover fractions of finest texels
  std::vector<LevelSchedule> levels;  // coarsest first, down to level 1 or MovmfSettings::first_level
};

/// A texel of up to this many samples is summed by one work-item in one go; larger ones are condensed, or summed in
/// chunks. By the sample count alone, so that summation order never depends on tiles or devices. 1024: the packed
/// normals of a group still fit a core's cache, and rounding of a plain sum stays below 1e-6.
constexpr int kSamplesUnchunkedMax = 1024;
/// Where settled texels stop, one of at most so many normals (level 1) runs kIterationsFewNormals iterations instead:
/// lobes find them at once and then creep, and stopping where they have all but stopped costs up to a fifth more error.
constexpr int kFewNormals = 4;
constexpr int kIterationsFewNormals = 8;
/// Samples a chunk sums, about: in EM, and where cells are filled.
constexpr int kSamplesPerChunk = 4096;
constexpr int kSamplesPerCondensedChunk = 65536;

/// For rows of so many samples each: a chunk's rows, and chunks a texel.
void set_chunks(MultumMovmfFit& fit, int samples_per_chunk, int samples_per_row);

/// `weighted`: use the kernels that weigh samples even where whole texels are covered (the same result).
MipSchedule make_mip_schedule(int map_width, int map_height, const MovmfSettings& settings, bool weighted = false);

}  // namespace multum
