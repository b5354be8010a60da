// SPDX-License-Identifier: Apache-2.0
// Caches data that takes long to compute from a BRDF, such as fits and tables, for the last few BRDFs. Objects with
// several BRDFs then do not repeat the work in every frame, and a BRDF that changes does not fill the memory.
#pragma once

#include <algorithm>
#include <iterator>
#include <list>
#include <utility>

#include "host/formats/brdf/brdf.h"

namespace multum::gl {

/// Returns whether two BRDFs reflect light in the same way, apart from colours.
inline bool same_reflection(const Brdf& a, const Brdf& b) {
  return a.kind == b.kind && a.f0 == b.f0 && a.term_count == b.term_count && a.measured == b.measured &&
         std::all_of(std::begin(kBrdfNumbers), std::end(kBrdfNumbers),
                     [&](float Brdf::*number) { return a.*number == b.*number; });
}

template <typename Value>
class KeptOfBrdf {
 public:
  static constexpr std::size_t kMost = 16;

  /// Returns the cached value of a BRDF with the same reflection, or else the value of `make(brdf)`. The address stays
  /// valid until kMost other BRDFs were used.
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
  std::list<std::pair<Brdf, Value>> kept_;  // the most recently used is last
};

}  // namespace multum::gl
