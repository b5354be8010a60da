// SPDX-License-Identifier: Apache-2.0
// Finds the code that a shader variant holds: the preprocessed text of the functions that main() reaches.
#pragma once

#include <string>

namespace multum::testing {

/// `fragment`: flags as #define and all texts, from multum-view --shaders. `scratch`: a file to write.
std::string reached_code(const std::string& fragment, const std::string& scratch);

}  // namespace multum::testing
