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

/// What parse_brdf() reads, F0 in it where the family has one; `measured_file`: the text of a measurement.
std::string brdf_text(const Brdf& brdf, const std::string& measured_file);

/// Why errors of it cannot be measured, or an environment cannot light it: what was found and what was expected; empty
/// where they can.
std::string measuring_refusal(const Brdf& brdf);
std::string environment_refusal(const Brdf& brdf);

/// The family, and the specular part that it has where nothing else is said.
void set_family(const BrdfFamily& family, Brdf& brdf);
/// A measurement, and its diffuse part. Throws Error(kInput).
void set_measured(const std::string& path, Brdf& brdf);

}  // namespace multum
