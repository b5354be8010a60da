// SPDX-License-Identifier: Apache-2.0
// Remembers where bakes of one map start. Searching takes 0.2 to 1 s of processor time whatever the map's size, which
// is nearly all that a bake of a small map takes; bakes whose settings differ in what the search does not see, such as
// how lobes are stored, start alike.
#pragma once

#include <optional>
#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/movmf_start.h"
#include "host/foundation/base/run_times.h"

namespace multum {

/// The candidates of start_candidates().
struct StartCandidates {
  std::vector<std::vector<MultumVmfLobe>> starts;
  RunTime time;  // that finding them took
};

/// The best of them for some settings.
struct ChosenStart {
  std::vector<MultumVmfLobe> start;
  int tried = 0;  // candidates
  RunTime time;   // that finding and trying them took, on kernels that were loaded
};

/// Of one map, and one device; bakes use it one after the other.
class StartMemory {
 public:
  /// Null: they were not found yet.
  const StartCandidates* candidates(int lobe_count, float kappa_max) const;
  const StartCandidates& remember(int lobe_count, float kappa_max, StartCandidates found);
  /// `settings`: of the bakes that candidates were tried with.
  const ChosenStart* chosen(const MovmfSettings& settings) const;
  void remember(const MovmfSettings& settings, ChosenStart chosen);

 private:
  struct OfCandidates {
    int lobe_count;
    float kappa_max;
    StartCandidates found;
  };
  struct OfChosen {
    MovmfSettings settings;
    ChosenStart chosen;
  };
  std::vector<OfCandidates> candidates_;
  std::vector<OfChosen> chosen_;
};

}  // namespace multum
