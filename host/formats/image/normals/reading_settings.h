// SPDX-License-Identifier: Apache-2.0
// Stores in the baked file how a map was read, so that another program can read the map in the same way.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// Adds every setting that changes the reading: bump_format, green, signed, two_channel, height_scale, wrap and fixnan.
/// Adds normal_scale if it is not 1, z_range if it is given, and dequantize if it is requested.
void add_reading_settings(const NormalMapSettings& settings, nlohmann::json& json);

/// Reads settings from `text`, the value of multum:settings in the file (docs/reference/file_format.md). Missing and
/// unknown settings keep their defaults, so files of other writers are read like maps without settings.
NormalMapSettings parse_reading_settings(const std::string& text);

}  // namespace multum
