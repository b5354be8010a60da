// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/form_shading.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "host/formats/brdf/ggx_lobe_specular.h"

namespace multum {
namespace {

constexpr double kLightIntensity = 3.0, kRoomIntensity = 0.3;  // equal to the scenes of docs/evidence/GLTF_EXAMPLE.md
constexpr double kRoughnessLeast = 0.045;                      // minimum of three.js and Filament
constexpr double kDielectric = 0.04;                           // reflectance along the normal

const std::array<glm::dvec3, kFormLights>& form_lights() {
  static const std::array<glm::dvec3, kFormLights> lights = {glm::normalize(glm::dvec3(1.0, 1.0, 0.6)),
                                                             glm::normalize(glm::dvec3(-0.8, 0.5, 0.7)),
                                                             glm::normalize(glm::dvec3(0.2, 0.7, -0.5))};
  return lights;
}

double schlick(double f0, double cosine) { return f0 + (1.0 - f0) * std::pow(1.0 - std::clamp(cosine, 0.0, 1.0), 5.0); }

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

// Returns the light that a surface with this alpha reflects from a direction of the room. Normals have a variance of
// alpha^2 / 2, and reflections are turned by twice the angle of the normal.
double room_at(const glm::dvec3& direction, double alpha) {
  double sum = walls_at(direction.y, 0.1 + alpha);
  for (const Lamp& lamp : lamps()) {
    const double kappa = 1.0 / (2.0 * alpha * alpha + lamp.solid_angle / (4.0 * std::numbers::pi));
    sum += lamp.radiance * lamp.solid_angle * kappa / (2.0 * std::numbers::pi * (1.0 - std::exp(-2.0 * kappa))) *
           std::exp(kappa * (glm::dot(direction, lamp.direction) - 1.0));
  }
  return sum;
}

// Returns the irradiance divided by pi.
double room_around(const glm::dvec3& normal) {
  double sum = walls_at(normal.y, 1.0);
  for (const Lamp& lamp : lamps())
    sum += lamp.radiance * lamp.solid_angle * std::max(glm::dot(normal, lamp.direction), 0.0) / std::numbers::pi;
  return sum;
}

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

double room_light(const glm::dvec3& normal, const FormSurface& surface, double room_roughness, double n_v,
                  const glm::dvec3& view) {
  const glm::dvec3 reflected = 2.0 * glm::dot(normal, view) * normal - view;
  const double specular =
      room_at(reflected, room_roughness * room_roughness) * split_sum(reflectance_of(surface), surface.roughness, n_v);
  const double diffuse = room_around(normal) * surface.colour * (1.0 - surface.metalness);
  return kRoomIntensity * (specular + diffuse);
}

}  // namespace

FormLight shaded_normal(const glm::dvec3& normal, const FormSurface& surface, const glm::dvec3& view) {
  const double roughness = std::max(surface.roughness, kRoughnessLeast), alpha = roughness * roughness;
  const double a2 = alpha * alpha, f0 = reflectance_of(surface), n_v = std::max(glm::dot(normal, view), 1e-4);
  const double view_side = std::sqrt(a2 + (1.0 - a2) * n_v * n_v);
  const double room_roughness = std::max(surface.room_roughness.value_or(roughness), kRoughnessLeast);
  const double room = room_light(normal, surface, room_roughness, n_v, view);
  FormLight made;
  for (std::size_t i = 0; i < kFormLights; ++i) {
    const glm::dvec3& light = form_lights()[i];
    const double n_l = glm::dot(normal, light);
    made[i] = room;
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

FormLight shaded_lobe(const glm::dvec4& lobe, const FormSurface& surface, const glm::dvec3& view) {
  const double roughness = std::max(surface.roughness, kRoughnessLeast), alpha = roughness * roughness;
  const double length = glm::length(glm::dvec3(lobe)), spread = std::clamp(1.0 - length / lobe.w, 0.0, 1.0);
  const glm::dvec3 mean = length > 1e-12 ? glm::dvec3(lobe) / length : view;
  const double f0 = reflectance_of(surface), kappa = std::max(kappa_of_spread(spread), 1e-6);
  const double wide = std::pow(std::min(alpha * alpha + 2.0 / kappa, 1.0), 0.25);
  const double room = room_light(mean, surface, wide, shaded_mean_cosine(spread, glm::dot(mean, view)), view);
  const GgxOverLobe shaded(glm::dvec4(glm::dvec3(lobe) / lobe.w, 1.0), alpha);
  FormLight made;
  for (std::size_t i = 0; i < kFormLights; ++i) {
    const glm::dvec3& light = form_lights()[i];
    const glm::dvec3 half = glm::normalize(light + view);
    const double fresnel = schlick(f0, glm::dot(view, half));
    const double diffuse = surface.colour * (1.0 - surface.metalness) * (1.0 - fresnel) / std::numbers::pi *
                           shaded_mean_cosine(spread, glm::dot(mean, light));
    made[i] = room + kLightIntensity * (shaded.specular(light, view, half) * fresnel + diffuse);
  }
  return made;
}

double roughness_of_variance(double roughness, const glm::dvec3& along_x, const glm::dvec3& along_y) {
  const double variance = (glm::dot(along_x, along_x) + glm::dot(along_y, along_y)) / 12.0;
  return std::min(std::pow(std::pow(std::max(roughness, kRoughnessLeast), 4.0) + variance, 0.25), 1.0);
}

}  // namespace multum
