// SPDX-License-Identifier: Apache-2.0
// Reads object-index images. The grey value of a pixel is the index of the object that the pixel shows. 0 means no
// object.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// For each of `indices`, returns 1 where the image has that value, and 0 elsewhere. The result has width * height
/// floats, with row 0 at the top. Throws Error(kInput), which names the file, if it is unreadable, has another size, or
/// is not 8- or 16-bit grey.
std::vector<std::vector<float>> read_object_index_coverage(const std::string& path, int width, int height,
                                                           const std::vector<int>& indices);

}  // namespace multum
