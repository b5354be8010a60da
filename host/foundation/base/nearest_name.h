// SPDX-License-Identifier: Apache-2.0
// Finds the known name that is closest to a misspelt one.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Returns the name in `known` with the smallest edit distance to `name`, for "did you mean". Returns an empty text if
/// all distances exceed both 2 letters and half the length of `name`.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

}  // namespace multum
