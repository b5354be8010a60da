// SPDX-License-Identifier: Apache-2.0
// Reads environment maps over latitude and longitude: OpenEXR, Radiance (.hdr), or any format of albedo images.
#pragma once

#include <string>

#include "host/formats/image/colour_map.h"

namespace multum {

constexpr int kEnvironmentWidthLimit = 16384;

/// Returns linear radiance. Negative and non-finite values become 0 and are counted. Throws Error(kInput) if the map is
/// damaged, not twice as wide as high, smaller than 8 x 4, or wider than the limit.
ColourMap read_environment_map(const std::string& path);
/// Checks only the size. Throws like read_environment_map().
void check_environment_map(const std::string& path);

}  // namespace multum
