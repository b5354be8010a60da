// SPDX-License-Identifier: Apache-2.0
// Finds the code of a shader variant, which is the preprocessed text of the functions that main() reaches.
#pragma once

#include <string>

namespace multum::testing {

/// `fragment` holds the flags as #define lines and all texts, as multum-view --shaders writes them. `scratch` is a file
/// that may be overwritten.
std::string reached_code(const std::string& fragment, const std::string& scratch);

}  // namespace multum::testing
