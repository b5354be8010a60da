// SPDX-License-Identifier: Apache-2.0
// Makes the rows that several tables have.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// `device`; `surfaces`: of it.
Parameter device_parameter(unsigned surfaces);
/// `memory`, from `low` bytes; `default_text` in words.
Parameter memory_parameter(const std::string& help, double low, const std::string& default_text, unsigned surfaces);
Parameter compression_parameter(unsigned surfaces);
/// `surface`; `more` ends its help text.
Parameter surface_parameter(const std::string& more, unsigned surfaces);
/// `anisotropy` and `fast`, of command lines that fit one lobe a texel.
Parameter lobe_anisotropy_parameter(unsigned surfaces);
Parameter fast_lobe_parameter(unsigned surfaces);
/// `form` and `for`, of commands that choose what a material's normals become; `shown` is what pictures show.
Parameter form_parameter(const std::string& shown, const std::string& default_text, unsigned surfaces);
Parameter engine_parameter(unsigned surfaces);
/// `uastc_effort` and `encoder`, of commands that have textures encoded as UASTC.
Parameter uastc_effort_parameter(unsigned surfaces);
Parameter encoder_parameter(unsigned surfaces);
/// `absolute_geometry`, of command lines: jobs of the service always have it.
Parameter absolute_geometry_parameter();
/// `input`, `scene` or another file that is read first.
Parameter input_parameter(const std::string& name, const std::string& help, unsigned surfaces);
/// What blue of a normal map holds: `two_channel` and `z_range`.
Parameter two_channel_parameter(unsigned surfaces);
Parameter z_range_parameter(unsigned surfaces);
/// `wrap`, `swrap`, `twrap`. `with_auto`: what the map itself shows may decide.
std::vector<Parameter> wrap_parameters(bool with_auto, const std::string& default_text, unsigned surfaces);

}  // namespace multum
