// SPDX-License-Identifier: Apache-2.0
// Parses a BRDF as options name it: lambert, blinn-phong:100, torrance-sparrow:0.1, cook-torrance:0.1,0.04, ggx:0.4,
// ggx:0.4,0.04, or a measured BRDF's file.
#pragma once

#include <string>

#include "host/formats/brdf/brdf.h"

namespace multum {

/// Diffuse and specular as the family has them where nothing else is said: of a measurement its own, of those with
/// Schlick's F a specular of 1, of Lambert none. Throws Error(kUsage) naming `option`, Error(kInput) for a file.
Brdf parse_brdf(const std::string& option, const std::string& text, int term_count);

/// Does `text` name a file?
bool is_brdf_file(const std::string& text);

}  // namespace multum
