// SPDX-License-Identifier: Apache-2.0
// Makes the rows that several parameter tables share.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Makes `device`. In this file, `surfaces` lists the places where users may give the parameter.
Parameter device_parameter(unsigned surfaces);
/// Makes `memory`, with at least `low` bytes; `default_text` is a human-readable default.
Parameter memory_parameter(const std::string& help, double low, const std::string& default_text, unsigned surfaces);
Parameter compression_parameter(unsigned surfaces);
/// Makes `surface`, and appends `more` to its help text.
Parameter surface_parameter(const std::string& more, unsigned surfaces);
/// Makes `anisotropy` and `fast`, for commands that fit one lobe per texel.
Parameter lobe_anisotropy_parameter(unsigned surfaces);
Parameter fast_lobe_parameter(unsigned surfaces);
/// Makes `form` and `for`, for commands that choose the form of a material's normals. `choice` says how auto chooses,
/// and `effect` what an engine changes.
Parameter form_parameter(const std::string& choice, const std::string& default_text, unsigned surfaces);
Parameter engine_parameter(const std::string& effect, unsigned surfaces);
/// Makes `uastc_effort` and `encoder`, for commands that encode textures as UASTC.
Parameter uastc_effort_parameter(unsigned surfaces);
Parameter encoder_parameter(unsigned surfaces);
/// Makes `absolute_geometry`, only for command lines, because jobs of the service always set it.
Parameter absolute_geometry_parameter();
/// Makes `input`, `scene` or another file that a command reads first.
Parameter input_parameter(const std::string& name, const std::string& help, unsigned surfaces);
/// Makes `two_channel` and `z_range`, which describe the contents of the blue channel of a normal map.
Parameter two_channel_parameter(unsigned surfaces);
Parameter z_range_parameter(unsigned surfaces);
/// Makes `wrap`, `swrap` and `twrap`; `with_auto` adds the choice auto, which depends on the map.
std::vector<Parameter> wrap_parameters(bool with_auto, const std::string& default_text, unsigned surfaces);

}  // namespace multum
