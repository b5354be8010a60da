// SPDX-License-Identifier: Apache-2.0
// The linear map of texture coordinates that is closest to an isometry with the screen (Hakura et al. 2000,
// section 3.4, eq. 7): each edge of a visible triangle should be as long in texels as it is in pixels.
#pragma once

#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

namespace multum {

/// An edge in one view. Triangles that share an edge may each give it with their own area: the terms of the sum are the
/// same, so that their weights add up to the paper's W_i.
struct IsometricEdge {
  glm::dvec2 uv;  // from its one end to the other
  double length;  // s_i, pixels, > 0
  double weight;  // W_i, square pixels
};

/// f of eq. 7, and its derivative by each element of `map` if `gradient` is not null. Infinite where the map makes a
/// point of an edge.
double isometric_cost(const std::vector<IsometricEdge>& edges, const glm::dmat2& map, glm::dmat2* gradient);

struct IsometricSettings {
  bool is_diagonal = false;  // b = c = 0 (footnote 5)
  int iterations_max = 200;
  double change_min = 1e-12;  // of f, relative, in one iteration: below it the search ends
};

/// Minimises isometric_cost() by conjugate gradient from the regular map `start`. Rotations of the result are as good.
glm::dmat2 fit_isometric_map(const std::vector<IsometricEdge>& edges, const glm::dmat2& start,
                             const IsometricSettings& settings);

}  // namespace multum
