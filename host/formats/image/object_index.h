// SPDX-License-Identifier: Apache-2.0
// Object-index images: the grey value of a pixel is the number of the object that it shows, 0 for none.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// 1 where the image has the value, else 0, for each of `indices`: width * height floats, row 0 at the top. Throws
/// Error(kInput) naming the file: unreadable, of another size, no 8- or 16-bit grey.
std::vector<std::vector<float>> read_object_index_coverage(const std::string& path, int width, int height,
                                                           const std::vector<int>& indices);

}  // namespace multum
