// SPDX-License-Identifier: Apache-2.0
// Caches what takes long to make of a BRDF, fits and tables, for the last few of them: objects of several BRDFs then do
// not make it anew in every frame, and a BRDF that moves leaves no more than those behind.
#pragma once

#include <algorithm>
#include <iterator>
#include <list>
#include <utility>

#include "host/formats/brdf/brdf.h"

namespace multum::gl {

/// Whether light is reflected alike but for colours.
inline bool same_reflection(const Brdf& a, const Brdf& b) {
  return a.kind == b.kind && a.f0 == b.f0 && a.term_count == b.term_count && a.measured == b.measured &&
         std::all_of(std::begin(kBrdfNumbers), std::end(kBrdfNumbers),
                     [&](float Brdf::*number) { return a.*number == b.*number; });
}

template <typename Value>
class KeptOfBrdf {
 public:
  static constexpr std::size_t kMost = 16;

  /// That of a BRDF that reflects alike, else `make(brdf)`; stays where it is for kMost - 1 others.
  template <typename Make>
  Value& of(const Brdf& brdf, const Make& make) {
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& one) { return same_reflection(one.first, brdf); });
    if (found != kept_.end()) kept_.splice(kept_.end(), kept_, found);
    else kept_.emplace_back(brdf, make(brdf));
    if (kept_.size() > kMost) kept_.pop_front();
    return kept_.back().second;
  }

 private:
  std::list<std::pair<Brdf, Value>> kept_;  // the last used one last
};

}  // namespace multum::gl
