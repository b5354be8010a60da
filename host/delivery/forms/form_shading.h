// SPDX-License-Identifier: Apache-2.0
// The light of a pixel as engines shade it, grey and in double: three directional lights, one picture each, and a room
// with lamps, which rough surfaces reflect blurred. GGX with Smith's height-correlated visibility, Schlick's Fresnel
// and Lambert (glTF 2.0, appendix B; host/delivery/export/accuracy/lobe_shading.h has the sources).
#pragma once

#include <array>
#include <optional>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

constexpr std::size_t kFormLights = 3;
/// A pixel's light under each of them.
using FormLight = std::array<double, kFormLights>;

/// What is shaded beside its normal.
struct FormSurface {
  double roughness = 1.0;  // perceptual
  double metalness = 0.0;
  double colour = 0.5;  // of the base
  // Of what the room is reflected with, where an engine takes another one.
  std::optional<double> room_roughness = std::nullopt;
};

/// One normal, unit. `view`: unit, towards the eye.
FormLight shaded_normal(const glm::dvec3& normal, const FormSurface& surface, const glm::dvec3& view);
/// The part of a lobe of normals, (a r, a) of amplitude 1, as @multum/three shades it (lobe_shading.js).
FormLight shaded_lobe(const glm::dvec4& lobe, const FormSurface& surface, const glm::dvec3& view);

/// Roughness where the geometry's normal changes by these from pixel to pixel, with the variance of slopes that a box
/// of one pixel sees (Kaplanyan et al. 2016; Tokuyoshi and Kaplanyan 2019): @multum/three's.
double roughness_of_variance(double roughness, const glm::dvec3& along_x, const glm::dvec3& along_y);

}  // namespace multum
