// SPDX-License-Identifier: Apache-2.0
// Finds the known name that a misspelt one was meant to be.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Returns the name of `known` with the least edit distance to `name`, for "did you mean"; empty where none is near:
/// more than 2 letters and more than half of the name off.
std::string nearest_name(const std::string& name, const std::vector<std::string>& known);

}  // namespace multum
