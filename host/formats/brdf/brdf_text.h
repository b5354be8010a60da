// SPDX-License-Identifier: Apache-2.0
// Parses a BRDF in the form that options use: lambert, blinn-phong:100, torrance-sparrow:0.1, cook-torrance:0.1,0.04,
// ggx:0.4, ggx:0.4,0.04, or the file of a measured BRDF.
#pragma once

#include <string>

#include "host/formats/brdf/brdf.h"

namespace multum {

/// Parses the text, and sets the default diffuse and specular parts of the family. A measurement has its own diffuse
/// part, families with Schlick's F have a specular part of 1, and Lambert has no specular part. Throws Error(kUsage),
/// which names `option`, or Error(kInput) for a file.
Brdf parse_brdf(const std::string& option, const std::string& text, int term_count);

/// Returns whether `text` names a file.
bool is_brdf_file(const std::string& text);

/// Returns a text that parse_brdf() reads, with F0 if the family has it. `measured_file` is the text for a measurement.
std::string brdf_text(const Brdf& brdf, const std::string& measured_file);

/// Return why errors cannot be measured for the BRDF, or why an environment cannot light it. The text has the form
/// "found ..., expected ...". It is empty if there is no obstacle.
std::string measuring_refusal(const Brdf& brdf);
std::string environment_refusal(const Brdf& brdf);

/// Sets the family and its default specular part.
void set_family(const BrdfFamily& family, Brdf& brdf);
/// Reads a measurement and sets its diffuse part. Throws Error(kInput).
void set_measured(const std::string& path, Brdf& brdf);

}  // namespace multum
