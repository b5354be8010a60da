// SPDX-License-Identifier: Apache-2.0
// Launches moment_finest and moment_shade on what a case says. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/opencl/device.h"
#include "kernels/shared/moments.h"

namespace multum {

/// Planes of each normal, [normal][plane].
std::vector<std::vector<float>> finest_moments(Device& device, const std::vector<glm::vec3>& normals, bool shortened);

/// Blinn-Phong of exponent s at each unit half vector, `shading` MULTUM_SHADE_...; last Lambert, of the first vector.
std::vector<double> shade_moments(Device& device, const MultumFilteredMoments& moments, int shading, double s,
                                  const std::vector<glm::vec4>& half_vectors);

}  // namespace multum
