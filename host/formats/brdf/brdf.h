// SPDX-License-Identifier: Apache-2.0
// The settings of the reflection at a smooth point of the surface. They are a family of the table
// (host/foundation/brdf_families) and values of its members.
#pragma once

#include <memory>
#include <optional>

#include <glm/vec3.hpp>

#include "host/foundation/brdf_families/brdf_families.h"

namespace multum {

struct MeasuredBrdf;

struct Brdf {
  BrdfKind kind = BrdfKind::kBlinnPhong;
  // The members of all families. Each family ignores the members that belong only to other families.
  float exponent = 100.0f, sigma = 0.1f, roughness = 0.5f;
  glm::vec3 f0{0.04f};       // F at normal incidence
  int term_count = 4;        // number of vMF lobes (1..4) in the sum that BrdfFit::kSum fits to f for shading lobes
  glm::vec3 diffuse{0.5f};   // the factor k_d
  glm::vec3 specular{0.1f};  // the factor k_s
  // A constant that replaces F for surfaces on which v.h varies little (host/formats/brdf/fresnel.h). It is used only
  // for lights, not for environments.
  std::optional<glm::vec3> fixed_fresnel = {};
  std::shared_ptr<const MeasuredBrdf> measured;
};

constexpr int kBrdfTermCountMax = 4;

/// Pointers to the numeric members, in the order of BrdfField. The last field, kF0, is not in the list because it is a
/// colour.
constexpr float Brdf::*kBrdfNumbers[] = {&Brdf::exponent, &Brdf::sigma, &Brdf::roughness};

inline const BrdfFamily& family_of(const Brdf& brdf) { return brdf_family(brdf.kind); }

/// Returns the width, for families that have one.
inline float& width_of(const BrdfFamily& family, Brdf& brdf) {
  return brdf.*kBrdfNumbers[static_cast<std::size_t>(family.members[0].field)];
}
/// Returns the width, or 0 if the family has no width.
inline float width_of(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  return family.has_width() ? brdf.*kBrdfNumbers[static_cast<std::size_t>(family.members[0].field)] : 0.0f;
}

/// Returns whether f convolved with lobes is a fitted sum of vMF lobes, because no single vMF or Gaussian is close to
/// f.
inline bool is_vmf_sum(const Brdf& brdf) { return family_of(brdf).fit == BrdfFit::kSum; }

inline float ggx_alpha(const Brdf& brdf) { return brdf.roughness * brdf.roughness; }

/// Returns whether the specular part is not black.
inline bool has_highlight(const Brdf& brdf) {
  return family_of(brdf).fit != BrdfFit::kNone && brdf.specular != glm::vec3(0.0f);
}

}  // namespace multum
