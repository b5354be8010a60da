// SPDX-License-Identifier: Apache-2.0
// Environment maps over latitude and longitude: OpenEXR, Radiance (.hdr), or any image that albedos come in.
#pragma once

#include <string>

#include "host/formats/image/colour_map.h"

namespace multum {

constexpr int kEnvironmentWidthLimit = 16384;

/// Linear radiance; what is negative or not finite is read as 0 and counted. Throws Error(kInput): not twice as wide as
/// high, smaller than 8 x 4 or wider than the limit, damaged.
ColourMap read_environment_map(const std::string& path);
/// Looks at its size alone. Throws as read_environment_map() does.
void check_environment_map(const std::string& path);

}  // namespace multum
