// SPDX-License-Identifier: Apache-2.0
// Stores how a map was read in the baked file, so that another program reads the same map in the same way.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "host/formats/image/normals/normal_map.h"

namespace multum {

/// Adds every setting that changes what is read: bump_format, green, signed, two_channel, height_scale, wrap, fixnan;
/// normal_scale where it is not 1, z_range where it is given, dequantize where it is asked for.
void add_reading_settings(const NormalMapSettings& settings, nlohmann::json& json);

/// The settings that `text` (the file's multum:settings, docs/reference/file_format.md) states; what it does not state,
/// or states in a way that is not understood, stays at its default: files of other writers are read like maps nothing
/// is known of.
NormalMapSettings parse_reading_settings(const std::string& text);

}  // namespace multum
