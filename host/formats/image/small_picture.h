// SPDX-License-Identifier: Apache-2.0
// Reduces an image file to a small picture. The file is read in bands of rows, so a file of any size needs memory for
// only a few rows.
#pragma once

#include <string>

#include "host/formats/image/files/png_writer.h"

namespace multum {

/// Returns means of the file's own values over areas. Neither side exceeds `side_max`, and the ratio of the sides is
/// kept. Smaller files keep their size. A single channel becomes grey, stretched from the smallest to the largest mean.
/// With two channels, the third is 1, as in a normal map. Floats with negative values are interpreted as -1..1, and a
/// range beyond 1 is compressed to fit. Throws Error(kInput) like ImageReader.
Png8Image read_small_picture(const std::string& path, int side_max);

}  // namespace multum
