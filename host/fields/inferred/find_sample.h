// SPDX-License-Identifier: Apache-2.0
// Finds the point of the parameter grid that a user names. The user gives either its indices, such as "3,5", or the
// sample's name.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "host/foundation/base/error.h"

namespace multum {

/// Returns the index in `samples` of the entry whose `at` or `name` is `text`. `samples` must not be empty. Throws
/// Error(kUsage) with the valid values.
template <typename Sample>
std::size_t find_sample(const std::vector<Sample>& samples, const std::vector<std::string>& parameters,
                        const std::string& text) {
  const auto indices = [](const Sample& sample) { return fmt::format("{}", fmt::join(sample.at, ",")); };
  for (std::size_t s = 0; s < samples.size(); ++s)
    if (samples[s].name == text || indices(samples[s]) == text) return s;
  throw Error(
      ErrorCode::kUsage,
      fmt::format("sample '{}': expected the indices {} from {} to {}, or a sample's name such as {}", text,
                  fmt::join(parameters, ","), indices(samples.front()), indices(samples.back()), samples.front().name));
}

}  // namespace multum
