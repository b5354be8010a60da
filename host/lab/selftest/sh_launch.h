// SPDX-License-Identifier: Apache-2.0
// Launches sh_project and sh_shade on some normals.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/opencl/device.h"

namespace multum {

/// Coefficients of each normal [normal][l*l + l + m - 1], as sh_project writes them; `shortened`: lengths are a BRDF's
/// width.
std::vector<std::vector<float>> project_sh(Device& device, int order, const std::vector<glm::vec3>& normals,
                                           bool shortened = false);

/// Blinn-Phong of exponent s at each of the unit half vectors, or Lambert at lights where s is 0, of the same
/// coefficients: [direction]. `share` is that of stored levels; no level is left to the normal map.
std::vector<double> shade_sh(Device& device, int order, const std::vector<float>& coefficients, float share, float s,
                             const std::vector<glm::vec3>& directions);

}  // namespace multum
