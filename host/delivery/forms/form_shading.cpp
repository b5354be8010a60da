// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/form_shading.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "host/formats/brdf/ggx_lobe_specular.h"

namespace multum {
namespace {

constexpr double kLightIntensity = 3.0, kDim = 0.3;  // equal to the scenes of docs/evidence/GLTF_EXAMPLE.md
constexpr double kRoughnessLeast = 0.045;            // minimum of three.js and Filament
constexpr double kDielectric = 0.04;                 // reflectance along the normal

double schlick(double f0, double cosine) {
  const double x = 1.0 - std::clamp(cosine, 0.0, 1.0), x2 = x * x;
  return f0 + (1.0 - f0) * x2 * x2 * x;
}

// The lamps of a room that resembles RoomEnvironment of three.js. Smooth surfaces show their reflections.
struct Lamp {
  glm::dvec3 direction;
  double solid_angle, radiance;
};
const std::array<Lamp, 5>& lamps() {
  static const std::array<Lamp, 5> all = {{{glm::normalize(glm::dvec3(-0.70, 0.62, 0.36)), 0.0125, 50.0},
                                           {glm::normalize(glm::dvec3(-0.63, 0.70, -0.32)), 0.0125, 50.0},
                                           {glm::normalize(glm::dvec3(0.77, 0.63, -0.09)), 0.0725, 17.0},
                                           {glm::normalize(glm::dvec3(-0.03, 0.52, 0.85)), 0.082, 43.0},
                                           {glm::normalize(glm::dvec3(0.19, 0.66, -0.73)), 0.0167, 20.0}}};
  return all;
}

// Returns the radiance of the walls, which are brighter above.
double walls_at(double height, double width) { return 0.5 + 0.3 * height / std::sqrt(height * height + width * width); }

// Returns the light of a lamp that a surface with this alpha reflects. Normals have a variance of alpha^2 / 2, and
// reflections are turned by twice the angle of the normal.
double lamp_at(const Lamp& lamp, const glm::dvec3& direction, double alpha) {
  constexpr double kUnseen = -40.0,
                   kNarrow = 20.0;  // beyond these, the exponentials are below the rounding of a double
  const double kappa = 1.0 / (2.0 * alpha * alpha + lamp.solid_angle / (4.0 * std::numbers::pi));
  const double power = kappa * (glm::dot(direction, lamp.direction) - 1.0);
  if (power < kUnseen) return 0.0;
  const double whole = 2.0 * std::numbers::pi * (kappa > kNarrow ? 1.0 : 1.0 - std::exp(-2.0 * kappa));
  return lamp.radiance * lamp.solid_angle * kappa / whole * std::exp(power);
}

// Returns the light that a surface with this alpha reflects from a direction of the room.
double room_at(const glm::dvec3& direction, double alpha) {
  double sum = walls_at(direction.y, 0.1 + alpha);
  for (const Lamp& lamp : lamps()) sum += lamp_at(lamp, direction, alpha);
  return sum;
}

// Returns the irradiance of lamps divided by pi.
template <std::size_t kCount>
double lamps_around(const std::array<Lamp, kCount>& all, const glm::dvec3& normal) {
  double sum = 0.0;
  for (const Lamp& lamp : all)
    sum += lamp.radiance * lamp.solid_angle * std::max(glm::dot(normal, lamp.direction), 0.0) / std::numbers::pi;
  return sum;
}
double room_around(const glm::dvec3& normal) { return walls_at(normal.y, 1.0) + lamps_around(lamps(), normal); }

// A sky like those of daylight photographs (blender_city.exr and blender_forest.exr of Blender): the ground, the
// horizon, the zenith, the bright part around the sun, and the sun, which has about a quarter of the light.
constexpr double kGround = 0.2, kHorizon = 1.3, kZenith = 0.8, kEdge = 0.06;
const std::array<Lamp, 1>& sky_glow() {
  static const std::array<Lamp, 1> glow = {{{glm::normalize(glm::dvec3(0.5, 1.0, -0.4)), 0.6, 4.0}}};
  return glow;
}
Lamp sky_sun(const glm::dvec3& towards) { return {towards, 0.03, 80.0}; }

// Do the same for the sky as room_at() and room_around().
double gradient_at(double height, double width) {
  const double above = 0.5 + 0.5 * height / std::sqrt(height * height + width * width);
  return glm::mix(kGround, glm::mix(kHorizon, kZenith, std::clamp(height, 0.0, 1.0)), above);
}
double sky_at(const glm::dvec3& direction, double alpha) {
  return gradient_at(direction.y, kEdge + alpha) + lamp_at(sky_glow()[0], direction, alpha);
}
double sky_around(const glm::dvec3& normal) { return gradient_at(normal.y, 1.0) + lamps_around(sky_glow(), normal); }

// Computes kappa as in Banerjee et al. 2005.
double kappa_of_spread(double spread) {
  const double r = 1.0 - spread;
  return r * (3.0 - r * r) / std::max(spread * (2.0 - spread), 1e-12);
}

double reflectance_of(const FormSurface& surface) {
  return kDielectric + (surface.colour - kDielectric) * surface.metalness;
}

// Evaluates Karis's fit of the split sum ("Physically Based Shading on Mobile", 2014).
double split_sum(double f0, double roughness, double n_v) {
  const double rx = 1.0 - roughness, ry = 0.0425 - 0.0275 * roughness, rz = 1.04 - 0.572 * roughness,
               rw = 0.022 * roughness - 0.04;
  const double a = std::min(rx * rx, std::exp2(-9.28 * n_v)) * rx + ry;
  return f0 * (-1.04 * a + rz) + 1.04 * a + rw;
}

// Returns the pictures without directional lights. The sun of a sky is visible only in the last pictures.
FormLight surroundings_light(const FormScene& scene, const glm::dvec3& normal, const FormSurface& surface,
                             double own_roughness, double n_v, const glm::dvec3& view) {
  const glm::dvec3 reflected = 2.0 * glm::dot(normal, view) * normal - view;
  const double alpha = own_roughness * own_roughness;
  const bool is_sky = scene.surroundings == FormSurroundings::kSky;
  const double mirrored = split_sum(reflectance_of(surface), surface.roughness, n_v);
  const double scattered = surface.colour * (1.0 - surface.metalness);
  const double light = (is_sky ? sky_at(reflected, alpha) : room_at(reflected, alpha)) * mirrored +
                       (is_sky ? sky_around(normal) : room_around(normal)) * scattered;
  FormLight made;
  for (std::size_t i = 0; i < kFormSuns; ++i) {
    made[i] = kDim * light;
    double& bright = made[kFormSuns + i] = light;
    if (!is_sky) continue;
    const std::array<Lamp, 1> sun = {sky_sun(scene.suns[i])};
    bright += lamp_at(sun[0], reflected, alpha) * mirrored + lamps_around(sun, normal) * scattered;
  }
  return made;
}

}  // namespace

FormScene::FormScene()
    : suns{glm::normalize(glm::dvec3(1.0, 1.0, 0.6)), glm::normalize(glm::dvec3(-0.8, 0.5, 0.7)),
           glm::normalize(glm::dvec3(0.2, 0.7, -0.5))} {}

FormLight shaded_normal(const glm::dvec3& normal, const FormSurface& surface, const glm::dvec3& view,
                        const FormScene& scene) {
  const double roughness = std::max(surface.roughness, kRoughnessLeast), alpha = roughness * roughness;
  const double a2 = alpha * alpha, f0 = reflectance_of(surface), n_v = std::max(glm::dot(normal, view), 1e-4);
  const double view_side = std::sqrt(a2 + (1.0 - a2) * n_v * n_v);
  const double room_roughness = std::max(surface.room_roughness.value_or(roughness), kRoughnessLeast);
  FormLight made = surroundings_light(scene, normal, surface, room_roughness, n_v, view);
  for (std::size_t i = 0; i < kFormSuns; ++i) {
    const glm::dvec3& light = scene.suns[i];
    const double n_l = glm::dot(normal, light);
    if (n_l <= 0.0) continue;
    const glm::dvec3 half = glm::normalize(light + view);
    const double n_h = std::clamp(glm::dot(normal, half), 0.0, 1.0), d = n_h * n_h * (a2 - 1.0) + 1.0;
    const double fresnel = schlick(f0, glm::dot(view, half));
    const double visibility = 0.5 / (n_l * view_side + n_v * std::sqrt(a2 + (1.0 - a2) * n_l * n_l));
    const double specular = a2 / (std::numbers::pi * d * d) * visibility * fresnel;
    const double diffuse = surface.colour * (1.0 - surface.metalness) * (1.0 - fresnel) / std::numbers::pi;
    made[i] += kLightIntensity * n_l * (specular + diffuse);
  }
  return made;
}

FormLight shaded_lobe(const glm::dvec4& lobe, const FormSurface& surface, const glm::dvec3& view,
                      const FormScene& scene) {
  const double roughness = std::max(surface.roughness, kRoughnessLeast), alpha = roughness * roughness;
  const double length = glm::length(glm::dvec3(lobe)), spread = std::clamp(1.0 - length / lobe.w, 0.0, 1.0);
  const glm::dvec3 mean = length > 1e-12 ? glm::dvec3(lobe) / length : view;
  const double f0 = reflectance_of(surface), kappa = std::max(kappa_of_spread(spread), 1e-6);
  const double wide = std::pow(std::min(alpha * alpha + 2.0 / kappa, 1.0), 0.25);
  const GgxOverLobe shaded(glm::dvec4(glm::dvec3(lobe) / lobe.w, 1.0), alpha);
  FormLight made =
      surroundings_light(scene, mean, surface, wide, shaded_mean_cosine(spread, glm::dot(mean, view)), view);
  for (std::size_t i = 0; i < kFormSuns; ++i) {
    const glm::dvec3& light = scene.suns[i];
    const glm::dvec3 half = glm::normalize(light + view);
    const double fresnel = schlick(f0, glm::dot(view, half));
    const double diffuse = surface.colour * (1.0 - surface.metalness) * (1.0 - fresnel) / std::numbers::pi *
                           shaded_mean_cosine(spread, glm::dot(mean, light));
    made[i] += kLightIntensity * (shaded.specular(light, view, half) * fresnel + diffuse);
  }
  return made;
}

double roughness_of_variance(double roughness, const glm::dvec3& along_x, const glm::dvec3& along_y) {
  const double variance = (glm::dot(along_x, along_x) + glm::dot(along_y, along_y)) / 12.0;
  return std::min(std::pow(std::pow(std::max(roughness, kRoughnessLeast), 4.0) + variance, 0.25), 1.0);
}

}  // namespace multum
