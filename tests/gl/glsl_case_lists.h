// SPDX-License-Identifier: Apache-2.0
// The parts of the registry, one a folder of shaders.
#pragma once

#include "tests/gl/glsl_cases.h"

namespace multum::gl {

std::vector<GlslCase> glsl_brdf_cases();     // brdf/ and common/vmf_zonal.glsl
std::vector<GlslCase> glsl_common_cases();   // common/, but for movmf_shading.glsl
std::vector<GlslCase> glsl_light_cases();    // light/
std::vector<GlslCase> glsl_surface_cases();  // surface/

}  // namespace multum::gl
