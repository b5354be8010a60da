// SPDX-License-Identifier: Apache-2.0
// Computes the highlights D V (n . l) of GGX lobes under many lights at once, in double precision. V is the
// height-correlated visibility of Smith (Heitz 2014, "Understanding the masking-shadowing function", eq. 99). It has
// the form V = G / (4 (n . v) (n . l)), as in Filament and glTF. The Fresnel term is omitted, because it is equal for
// all lobes that are compared.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum {

/// One lobe in the form in which a renderer reads it.
struct GgxLobe {
  glm::dvec3 normal{0.0, 0.0, 1.0};  // unit vector
  double alpha_wide = 1.0;           // along the axis
  double alpha_narrow = 1.0;         // across the axis
  glm::dvec3 axis{1.0, 0.0, 0.0};    // unit vector, perpendicular to the normal

  static GgxLobe isotropic(const glm::dvec3& normal, double alpha);
};

/// Returns the projection of the x axis onto the tangent plane of the normal, normalised (Gram and Schmidt). Angles of
/// axes are measured from this tangent.
glm::dvec3 tangent_about(const glm::dvec3& normal);

/// The lights of one view, stored as planes. A light behind the surface may have no half vector. Its `share` is then 0.
struct LightSet {
  glm::dvec3 view{0.0, 0.0, 1.0};  // unit vector
  std::vector<double> x, y, z;     // unit vectors towards the lights
  std::vector<double> hx, hy, hz;  // unit half vectors
  std::vector<double> share;       // 1 / (pdf * count): weight of the light in an integral over directions

  std::size_t size() const { return x.size(); }
  /// Adds a light with share 0.
  void add(const glm::dvec3& light);
};

/// Adds weight * D V (n . l) of an isotropic lobe to `values`, and weight * D (n . h) to `densities`, for each light.
void add_highlights(const LightSet& lights, const glm::dvec3& normal, double alpha_squared, double weight,
                    double* values, double* densities);

/// Computes D V (n . l) of a lobe for each light.
void highlights(const LightSet& lights, const GgxLobe& lobe, std::vector<double>& values);

}  // namespace multum
