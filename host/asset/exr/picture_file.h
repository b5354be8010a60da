// SPDX-License-Identifier: Apache-2.0
// Writes pictures as OpenEXR files of linear 32-bit floats; a file appears whole or not at all.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// `rgba`: 4 * width * height values, row 0 at the top. Channels R, G, B, A, compressed by zip. Throws
/// Error(kEnvironment) when the disk refuses.
void write_exr_picture(const std::string& path, int width, int height, const std::vector<float>& rgba);

}  // namespace multum
