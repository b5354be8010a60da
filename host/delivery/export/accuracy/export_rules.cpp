// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/export_rules.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum {
namespace {

double averaged(double, double roughness) { return roughness; }

// V, the Toksvig variance of the normals minus the error of 8-bit storage, lowers the Beckmann exponent that
// corresponds to alpha. a2 is alpha^2.
double unreal(double length, double roughness) {
  const double a2 = std::pow(std::max(roughness, 1e-3), 4.0);
  if (a2 >= 1.0) return 1.0;
  const double variance = std::max(0.0, (1.0 - length) / length - 0.00004);
  const double b = 2.0 * variance * (a2 - 1.0);
  return std::pow(std::clamp((b - a2) / (b - 1.0), 0.0, 1.0), 0.25);
}

// TextureNormalVariance is 0.25 / kappa. NormalFiltering adds twice this variance, but at most the square of the
// threshold, which is 0.2 by default.
double unity(double length, double roughness) {
  constexpr double kThreshold = 0.2;
  const double variance = 0.25 / kappa_of_length(length), alpha = roughness * roughness;
  return std::pow(std::min(1.0, alpha * alpha + std::min(2.0 * variance, kThreshold * kThreshold)), 0.25);
}

// This rule acts on perceptual roughness, not on alpha.
double godot(double length, double roughness) {
  return std::min(1.0, std::sqrt(roughness * roughness + std::min(0.75 / kappa_of_length(length), 0.4 * 0.4)));
}

// This rule acts on the stored value, which is perceptual roughness.
double filament(double length, double roughness) {
  return std::min(1.0, std::sqrt(roughness * roughness + 2.0 / kappa_of_length(length)));
}

}  // namespace

const std::vector<EngineRule>& engine_rules() {
  static const std::vector<EngineRule> rules = {
      {"averaged", "averaged normals", "no rule: the base roughness is used at every level", averaged},
      {"unreal", "Unreal", "TextureCompressorModule.cpp, ApplyCompositeTexture, but without its blur of normals",
       unreal},
      {"unity", "Unity HDRP", "CommonMaterial.hlsl, TextureNormalVariance and NormalFiltering", unity},
      {"godot", "Godot", "core/io/image.cpp, Image::generate_mipmap_roughness", godot},
      {"filament", "Filament", "tools/roughness-prefilter, literally", filament}};
  return rules;
}

GgxLobe lobe_of_rule(const EngineRule& rule, const RuleInput& texel) {
  const double length = std::clamp(glm::length(texel.mean_normal), 1e-6, 1.0);
  const double roughness = rule.roughness(length, texel.roughness);
  return GgxLobe::isotropic(glm::normalize(texel.mean_normal), std::max(1e-3, roughness * roughness));
}

double kappa_of_length(double length) {
  const double r = std::min(length, 1.0 - 1e-9);
  return std::clamp((3.0 * r - r * r * r) / (1.0 - r * r), 1e-9, 1e9);
}

}  // namespace multum
