// SPDX-License-Identifier: Apache-2.0
// Holds the counts and times of a fit of lobes, which are part of the bake's report (host/bakes/bake/bake_report.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/foundation/base/run_times.h"

namespace multum {

struct LevelReport {
  int level, width, height;
  double seconds;
  std::uint64_t launches;
};

struct FitReport {
  std::string plan;            // text from BakePlan::to_text(), or the plan of plain averages
  double start_seconds = 0.0;  // time to choose the start of the coarsest level
  std::uint64_t start_launches = 0;
  int starts_tried = 0;          // number of candidates that were tried on a small proxy of the map
  RunTime start_remembered;      // search time of the earlier bake whose start was used (StartMemory)
  double binning_seconds = 0.0;  // time to bin the normals of coarse texels
  std::uint64_t binning_launches = 0;
  std::vector<LevelReport> levels;  // finest first
  // The numbers of rare numerical events in all texels and lobes of all levels.
  std::uint64_t lobe_count_total = 0;
  std::uint64_t nonfinite = 0;         // must be 0
  std::uint64_t kappa_clamped = 0;     // lobes with a kappa above MovmfSettings::kappa_cap; EM may have treated them as
                                       // less sharp
  std::uint64_t dead_lobes = 0;        // lobes with an amplitude below 1e-6; below 1e-7 (DEAD_SHARE), EM does not
                                       // change the direction
  std::uint64_t undirected_lobes = 0;  // lobes with |r| below 1e-3, whose normals point in opposite directions and
                                       // cancel
};

}  // namespace multum
