// SPDX-License-Identifier: Apache-2.0
// Remembers the starts of bakes of one map. A search takes 0.2 to 1 s of processor time for any map size. For a small
// map, this is most of the bake time. Two bakes use the same start if they differ only in settings that do not affect
// the search, such as the storage of lobes.
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
  RunTime time;  // time to find the candidates
};

/// The best candidate for some settings.
struct ChosenStart {
  std::vector<MultumVmfLobe> start;
  int tried = 0;  // number of candidates
  RunTime time;   // time to find and try the candidates
};

/// Serves successive bakes of one map on one device.
class StartMemory {
 public:
  /// If `is_timed` is true, an additional trial loads the kernels, so that ChosenStart::time does not include this.
  explicit StartMemory(bool is_timed = true) : is_timed_(is_timed) {}

  bool is_timed() const { return is_timed_; }
  /// Returns null if no search has been made.
  const StartCandidates* candidates(int lobe_count, float kappa_max) const;
  const StartCandidates& remember(int lobe_count, float kappa_max, StartCandidates found);
  /// `settings` are the settings of the bakes that tried the candidates.
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
  const bool is_timed_;
  std::vector<OfCandidates> candidates_;
  std::vector<OfChosen> chosen_;
};

}  // namespace multum
