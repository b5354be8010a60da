// SPDX-License-Identifier: Apache-2.0
// Fits one GGX lobe to the facets that a texel covers, to test kernels/one_lobe.cl. The code follows the definition and
// uses double precision. Also shades one lobe, to measure the errors of exports.
#pragma once

#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/image/normals/normal_map.h"

namespace multum::reference {

struct OneLobe {
  glm::dvec3 normal{0.0, 0.0, 1.0};             // unit vector
  double alpha_wide = 1.0, alpha_narrow = 1.0;  // roughness along and across the axis
  glm::dvec3 axis{1.0, 0.0, 0.0};               // unit vector in the normal's tangent plane; the opposite vector means
                                                // the same axis
};

/// A texel of a map, and the settings of its fit.
struct OneLobeTexel {
  const NormalMap* map;
  std::vector<double> base_squared;  // alpha^2 of each finest texel, or one value for all texels
  int width, height, x, y;           // size of the level, and position of the texel
  bool is_anisotropic;
  int iteration_count;  // number of EM iterations; if 0, only the closed form is computed
  double alpha_min;
};

/// Fits the lobe. `facets` contains the slopes of grid * grid facets of a surface with alpha 1, one per position of the
/// grid.
OneLobe fit_one_lobe(const OneLobeTexel& texel, const std::vector<glm::vec2>& facets, int grid);

/// Returns -2 times the mean log likelihood of slopes under a t distribution with two degrees of freedom, minus a
/// constant.
double t_deviance(const std::vector<glm::dvec2>& slopes, const glm::dvec2& mean, const glm::dmat2& scale);

/// Returns the slopes of the texel's samples in the frame of its mean normal.
std::vector<glm::dvec2> sampled_slopes(const OneLobeTexel& texel, const std::vector<glm::vec2>& facets, int grid);

}  // namespace multum::reference
