// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace multum {
namespace {

// Returns the Levenshtein distance: the smallest number of letters that must be inserted, removed or replaced.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearest_name(const std::string& name, const std::vector<std::string>& known) {
  std::string nearest;
  std::size_t least = std::max<std::size_t>(2, name.size() / 2);  // names at a larger distance are probably other words
  for (const std::string& candidate : known) {
    // The distance is at least the difference in length. Without this test, a name of several megabytes would take
    // minutes.
    const auto [shorter, longer] = std::minmax({name.size(), candidate.size()});
    if (longer - shorter > least) continue;
    const std::size_t distance = edit_distance(name, candidate);
    if (distance > least || (distance == least && !nearest.empty())) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

}  // namespace multum
