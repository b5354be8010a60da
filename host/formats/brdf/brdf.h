// SPDX-License-Identifier: Apache-2.0
// Describes the reflection of a smooth point of the surface, as plain settings: a family of the table
// (host/foundation/brdf_families) with values of its members.
#pragma once

#include <memory>
#include <optional>

#include <glm/vec3.hpp>

#include "host/foundation/brdf_families/brdf_families.h"

namespace multum {

struct MeasuredBrdf;

struct Brdf {
  BrdfKind kind = BrdfKind::kBlinnPhong;
  // Members of families, those of other families unused.
  float exponent = 100.0f, sigma = 0.1f, roughness = 0.5f;
  glm::vec3 f0{0.04f};       // F at normal incidence
  int term_count = 4;        // vMFs that f of BrdfFit::kSum is a sum of, over lobes: 1..4
  glm::vec3 diffuse{0.5f};   // k_d
  glm::vec3 specular{0.1f};  // k_s
  // In the place of F: of surfaces whose v.h differs little (host/formats/brdf/fresnel.h). Lights alone, no
  // environment.
  std::optional<glm::vec3> fixed_fresnel = {};
  std::shared_ptr<const MeasuredBrdf> measured;
};

constexpr int kBrdfTermCountMax = 4;

/// The numbers among the members, in the order of BrdfField, of which kF0, the colour, is the last.
constexpr float Brdf::*kBrdfNumbers[] = {&Brdf::exponent, &Brdf::sigma, &Brdf::roughness};

inline const BrdfFamily& family_of(const Brdf& brdf) { return brdf_family(brdf.kind); }

/// Of a family that has one.
inline float& width_of(const BrdfFamily& family, Brdf& brdf) {
  return brdf.*kBrdfNumbers[static_cast<std::size_t>(family.members[0].field)];
}
/// 0 where it has none.
inline float width_of(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  return family.has_width() ? brdf.*kBrdfNumbers[static_cast<std::size_t>(family.members[0].field)] : 0.0f;
}

/// Over lobes f is a fitted sum of vMFs: no single one, or Gaussian, is near it.
inline bool is_vmf_sum(const Brdf& brdf) { return family_of(brdf).fit == BrdfFit::kSum; }

inline float ggx_alpha(const Brdf& brdf) { return brdf.roughness * brdf.roughness; }

/// Its specular part is not black.
inline bool has_highlight(const Brdf& brdf) {
  return family_of(brdf).fit != BrdfFit::kNone && brdf.specular != glm::vec3(0.0f);
}

}  // namespace multum
