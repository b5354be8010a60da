// SPDX-License-Identifier: Apache-2.0
// Reduces an image file to a small picture, read by bands of rows: as large a file as any reader takes, in the memory
// of a few of its rows.
#pragma once

#include <string>

#include "host/formats/image/files/png_writer.h"

namespace multum {

/// Means over areas, of the numbers as the file holds them: neither width nor height is more than `side_max` after, and
/// both keep their ratio; smaller files keep their size. One channel is grey, stretched from its least to its largest
/// mean. With two the third is 1, as in a normal map. Floats with negative values are taken for -1..1, those beyond 1
/// are stretched. Throws Error(kInput) as ImageReader does.
Png8Image read_small_picture(const std::string& path, int side_max);

}  // namespace multum
