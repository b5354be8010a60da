// SPDX-License-Identifier: Apache-2.0
// Finds the linear map of texture coordinates that is closest to an isometry with the screen (Hakura et al. 2000,
// section 3.4, eq. 7). Each edge of a visible triangle should have the same length in texels as in pixels.
#pragma once

#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

namespace multum {

/// An edge in one view. Triangles that share an edge may each add it, with their own area as weight. The terms of these
/// triangles differ only in this weight, so the weights add up to W_i of the paper.
struct IsometricEdge {
  glm::dvec2 uv;  // vector between the ends
  double length;  // s_i, pixels, > 0
  double weight;  // W_i, square pixels
};

/// Returns f of eq. 7, and its derivatives with respect to the elements of `map` if `gradient` is not null. The result
/// is infinite if the map shrinks an edge to a point.
double isometric_cost(const std::vector<IsometricEdge>& edges, const glm::dmat2& map, glm::dmat2* gradient);

struct IsometricSettings {
  bool is_diagonal = false;  // b = c = 0 (footnote 5)
  int iterations_max = 200;
  double change_min = 1e-12;  // relative change of f per iteration that ends the search
};

/// Minimizes isometric_cost() by conjugate gradient, starting at `start`, which must be invertible. A rotation of the
/// result does not change the cost.
glm::dmat2 fit_isometric_map(const std::vector<IsometricEdge>& edges, const glm::dmat2& start,
                             const IsometricSettings& settings);

}  // namespace multum
