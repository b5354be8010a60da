// SPDX-License-Identifier: Apache-2.0
// The numerical cases of brdf/ and of vmf_zonal.glsl.
#pragma once

#include "tests/gl/glsl_cases.h"

namespace multum::gl {

std::vector<GlslCase> glsl_brdf_cases();

}  // namespace multum::gl
