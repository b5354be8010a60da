// SPDX-License-Identifier: Apache-2.0
// Launches sh_project and sh_shade for some normals.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/opencl/device.h"

namespace multum {

/// Returns the coefficients of each normal as [normal][l*l + l + m - 1], in the order of sh_project. If `shortened` is
/// true, the lengths of normals encode the width of a BRDF.
std::vector<std::vector<float>> project_sh(Device& device, int order, const std::vector<glm::vec3>& normals,
                                           bool shortened = false);

/// Shades the same coefficients with Blinn-Phong (exponent s) at each unit half vector. If s is 0, shades them with
/// Lambert at each light instead. The stored levels have the share `share`, and the normal map contributes nothing.
std::vector<double> shade_sh(Device& device, int order, const std::vector<float>& coefficients, float share, float s,
                             const std::vector<glm::vec3>& directions);

}  // namespace multum
