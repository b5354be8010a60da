// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/reflectance.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum::reference {

glm::dvec3 phong_radiance(const glm::dvec3& normal, const glm::dvec3& viewer, const std::vector<DistantLight>& lights,
                          const PhongSurface& surface) {
  glm::dvec3 sum(0.0);
  for (const DistantLight& light : lights) {
    const double cosine = std::max(glm::dot(normal, light.direction), 0.0);
    const double facets = std::max(glm::dot(normal, glm::normalize(light.direction + viewer)), 0.0);
    sum += light.irradiance * cosine *
           (surface.diffuse / M_PI +
            surface.specular * (surface.exponent + 1.0) / (2.0 * M_PI) * std::pow(facets, surface.exponent));
  }
  return sum;
}

}  // namespace multum::reference
