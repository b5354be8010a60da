// SPDX-License-Identifier: Apache-2.0
// The text forms of the table of BRDFs in words and as a pattern.
#pragma once

#include <string>
#include <string_view>

#include "host/foundation/brdf_families/brdf_families.h"

namespace multum {

/// "lambert, blinn-phong:S, ..., cook-torrance:SIGMA and ggx:ROUGHNESS" of the families that have a text; `last`: the
/// word before the last, "" for a comma. `with_f0`: "ggx:ROUGHNESS[,F0]".
std::string brdf_forms(std::string_view last, bool with_f0 = false);

/// What a refused text is told: the same with ranges, and files.
std::string expected_brdf();

/// "a number from 0.05 to 1", "radians from 0.002 to 1".
std::string range_text(const BrdfMember& member);

/// A regular expression, as JSON schemas have it, of a text that names a family and its numbers: no file's name.
const std::string& brdf_pattern();

}  // namespace multum
