// SPDX-License-Identifier: Apache-2.0
// Launches moment_finest and moment_shade with the inputs of a case. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/opencl/device.h"
#include "kernels/shared/moments.h"

namespace multum {

/// Returns the planes of each normal, [normal][plane].
std::vector<std::vector<float>> finest_moments(Device& device, const std::vector<glm::vec3>& normals, bool shortened);

/// Shades Blinn-Phong with exponent s at each unit half vector. Then shades Lambert at the first half vector. `shading`
/// is one of the constants whose names begin with MULTUM_SHADE_.
std::vector<double> shade_moments(Device& device, const MultumFilteredMoments& moments, int shading, double s,
                                  const std::vector<glm::vec4>& half_vectors);

}  // namespace multum
