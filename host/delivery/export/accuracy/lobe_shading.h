// SPDX-License-Identifier: Apache-2.0
// The highlight of GGX lobes under many lights at once, in double: D V (n . l), with the height-correlated visibility
// of Smith (Heitz 2014, "Understanding the masking-shadowing function", eq. 99; in the form of Filament and glTF,
// V = G / (4 (n . v) (n . l))). No Fresnel term: it is the same for all that is compared.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum {

/// One lobe as a renderer has it.
struct GgxLobe {
  glm::dvec3 normal{0.0, 0.0, 1.0};  // unit
  double alpha_wide = 1.0;           // along the axis
  double alpha_narrow = 1.0;         // across it
  glm::dvec3 axis{1.0, 0.0, 0.0};    // unit, square to the normal

  static GgxLobe isotropic(const glm::dvec3& normal, double alpha);
};

/// The x axis turned into the normal's tangent plane (Gram and Schmidt), which angles of axes are measured from.
glm::dvec3 tangent_about(const glm::dvec3& normal);

/// Lights of one view, plane by plane. Some lie behind the surface and have no half vector: `share` 0.
struct LightSet {
  glm::dvec3 view{0.0, 0.0, 1.0};  // unit
  std::vector<double> x, y, z;     // unit
  std::vector<double> hx, hy, hz;  // half vectors, unit
  std::vector<double> share;       // 1 / (pdf * count): what the light's value counts in an integral over directions

  std::size_t size() const { return x.size(); }
  /// Its share is left 0.
  void add(const glm::dvec3& light);
};

/// Adds weight * D V (n . l) of an isotropic lobe to `values`, and weight * D (n . h) to `densities`, light by light.
void add_highlights(const LightSet& lights, const glm::dvec3& normal, double alpha_squared, double weight,
                    double* values, double* densities);

/// D V (n . l) of a lobe, light by light.
void highlights(const LightSet& lights, const GgxLobe& lobe, std::vector<double>& values);

}  // namespace multum
