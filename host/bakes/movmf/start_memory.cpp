// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/start_memory.h"

#include <algorithm>
#include <utility>

namespace multum {

const StartCandidates* StartMemory::candidates(int lobe_count, float kappa_max) const {
  const auto found = std::find_if(candidates_.begin(), candidates_.end(), [&](const OfCandidates& one) {
    return one.lobe_count == lobe_count && one.kappa_max == kappa_max;
  });
  return found == candidates_.end() ? nullptr : &found->found;
}

const StartCandidates& StartMemory::remember(int lobe_count, float kappa_max, StartCandidates found) {
  candidates_.push_back({lobe_count, kappa_max, std::move(found)});
  return candidates_.back().found;
}

const ChosenStart* StartMemory::chosen(const MovmfSettings& settings) const {
  const auto found =
      std::find_if(chosen_.begin(), chosen_.end(), [&](const OfChosen& one) { return one.settings == settings; });
  return found == chosen_.end() ? nullptr : &found->chosen;
}

void StartMemory::remember(const MovmfSettings& settings, ChosenStart chosen) {
  chosen_.push_back({settings, std::move(chosen)});
}

}  // namespace multum
