// SPDX-License-Identifier: Apache-2.0
// Describes the text forms of BRDFs in the table, in words and as a pattern.
#pragma once

#include <string>
#include <string_view>

#include "host/foundation/brdf_families/brdf_families.h"

namespace multum {

/// Returns "lambert, blinn-phong:S, ..., cook-torrance:SIGMA and ggx:ROUGHNESS" for the families with a text form.
/// `last` is the word before the last form. If `last` is "", a comma is used. With `with_f0`, the form of GGX is
/// "ggx:ROUGHNESS[,F0]".
std::string brdf_forms(std::string_view last, bool with_f0 = false);

/// Returns the forms with their ranges, and the file form, for messages about a rejected text.
std::string expected_brdf();

/// Returns "a number from 0.05 to 1" or "radians from 0.002 to 1", for example.
std::string range_text(const BrdfMember& member);

/// Returns a regular expression, in the syntax of JSON schemas, that matches texts with the name and numbers of a
/// family, but not file names.
const std::string& brdf_pattern();

}  // namespace multum
