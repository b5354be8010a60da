// SPDX-License-Identifier: Apache-2.0
// Holds rows of a material with one GGX lobe per texel, in the form that engines use.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum {

/// A level, or some of its rows, in row-major order with row 0 at the top.
struct MaterialRows {
  int width = 0, height = 0;
  std::vector<glm::vec3> normals;     // unit vectors, or shorter means; x points right, y up, z out
  std::vector<float> roughness;       // perceptual roughness, sqrt(alpha), 0..1; with anisotropy, across the axis
  std::vector<glm::vec3> anisotropy;  // x, y: unit direction of the axis; z: strength, 0..1; empty if isotropic
  std::vector<float> occlusion;       // 0..1; empty if there is no such map
  std::vector<float> metalness;       // 0..1; empty if there is no such map
  std::vector<glm::vec3> means = {};  // means of normals; empty in level 0, or if OneLobeInputs::wants_means is not set
};

/// Receives finished rows. The rows of each level arrive from the top down. Levels arrive in any order.
class MaterialSink {
 public:
  virtual ~MaterialSink() = default;
  virtual void add_level(int level, int first_row, MaterialRows rows) = 0;
};

}  // namespace multum
