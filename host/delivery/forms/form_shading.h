// SPDX-License-Identifier: Apache-2.0
// Shades a pixel like an engine, in grey and in double precision. There are six pictures: three with a directional
// light each in dim surroundings, and three with bright surroundings alone. The surroundings are a room with lamps,
// which is always the same, or a sky, whose sun has three places. Rough surfaces blur their reflections. The model is
// GGX with Smith's height-correlated visibility, Schlick's Fresnel term and Lambert (glTF 2.0, appendix B; sources are
// in host/delivery/export/accuracy/lobe_shading.h).
#pragma once

#include <array>
#include <optional>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

constexpr std::size_t kFormSuns = 3, kFormLights = 2 * kFormSuns;
/// The light of a pixel in each picture, in the order above.
using FormLight = std::array<double, kFormLights>;

enum class FormSurroundings { kRoom, kSky };

/// The lights of a pixel. By default, these are three fixed directional lights in a room. The sun of a sky has the
/// directions of the lights.
struct FormScene {
  FormScene();

  FormSurroundings surroundings = FormSurroundings::kRoom;
  std::array<glm::dvec3, kFormSuns> suns;  // unit vectors towards the directional lights
};

/// The surface properties other than the normal.
struct FormSurface {
  double roughness = 1.0;  // perceptual roughness
  double metalness = 0.0;
  double colour = 0.5;  // base colour
  // Roughness for reflections of the room, if the engine uses a different one.
  std::optional<double> room_roughness = std::nullopt;
};

/// Shades one unit normal. `view` is a unit vector towards the eye.
FormLight shaded_normal(const glm::dvec3& normal, const FormSurface& surface, const glm::dvec3& view,
                        const FormScene& scene);
/// Shades the lobe of normals (a r, a) as @multum/three does (lobe_shading.js). The result is for a lobe with amplitude
/// 1.
FormLight shaded_lobe(const glm::dvec4& lobe, const FormSurface& surface, const glm::dvec3& view,
                      const FormScene& scene);

/// Returns the roughness that @multum/three uses where the geometry's normal changes from pixel to pixel. This
/// roughness includes the variance of slopes within a box of one pixel (Kaplanyan et al. 2016; Tokuyoshi and Kaplanyan
/// 2019).
double roughness_of_variance(double roughness, const glm::dvec3& along_x, const glm::dvec3& along_y);

}  // namespace multum
