// SPDX-License-Identifier: Apache-2.0
// Declares the parts of the registry of cases, grouped by shader.
#pragma once

#include "tests/gl/glsl/glsl_cases.h"

namespace multum::gl {

std::vector<GlslCase> glsl_lobe_cases();      // common/movmf_shading.glsl
std::vector<GlslCase> glsl_brdf_cases();      // brdf/ and common/vmf_zonal.glsl
std::vector<GlslCase> glsl_sampling_cases();  // common/footprint.glsl and blue_noise.glsl
std::vector<GlslCase> glsl_filter_cases();    // common/texture_filter.glsl and pyramid.glsl
std::vector<GlslCase> glsl_planar_cases();    // common/gmm_shading.glsl and moment_shading.glsl
std::vector<GlslCase> glsl_harmonic_cases();  // common/sh_shading.glsl
std::vector<GlslCase> glsl_light_cases();     // light/
std::vector<GlslCase> glsl_surface_cases();   // surface/

}  // namespace multum::gl
