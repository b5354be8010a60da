// SPDX-License-Identifier: Apache-2.0
// Describes the reflection of a smooth point of the surface, as plain settings. Times the cosine it is
//   k_d / pi (1 - F) max(n.l, 0) + k_s F f(n.h) V max(n.l, 0),
// f the density of facets, F what depends on v.h alone, V shadowing and masking over 4 n.l n.v.
#pragma once

#include <memory>
#include <optional>

#include <glm/vec3.hpp>

namespace multum {

struct MeasuredBrdf;

enum class BrdfKind {
  kLambert,          // no highlight
  kBlinnPhong,       // f = (s + 1) / (2 pi) (n.h)^s, F = V = 1
  kTorranceSparrow,  // f = vMF of kappa 1 / (2 sigma^2); F = V = 1: Fresnel and shadowing are left to `specular`
  kCookTorrance,     // the same f, Schlick's F, V of V-shaped grooves
  kGgx,              // as in glTF: alpha = roughness^2, Schlick's F, Smith's V
  kMeasured,         // f(n.h) and F(v.h) of `measured`, V = 1
};

struct Brdf {
  BrdfKind kind = BrdfKind::kBlinnPhong;
  float exponent = 100.0f;   // s, 1..1e5
  float sigma = 0.1f;        // radians, 0.002..1
  float roughness = 0.5f;    // 0.05..1
  glm::vec3 f0{0.04f};       // F at normal incidence, of kCookTorrance and kGgx
  int term_count = 4;        // vMFs that f of kGgx and kMeasured is a sum of, over lobes: 1..4
  glm::vec3 diffuse{0.5f};   // k_d
  glm::vec3 specular{0.1f};  // k_s
  // In the place of F: of surfaces whose v.h differs little (host/formats/brdf/fresnel.h). Lights alone, no
  // environment.
  std::optional<glm::vec3> fixed_fresnel = {};
  std::shared_ptr<const MeasuredBrdf> measured;
};

constexpr int kBrdfTermCountMax = 4;

inline float ggx_alpha(const Brdf& brdf) { return brdf.roughness * brdf.roughness; }

/// Its specular part is not black.
inline bool has_highlight(const Brdf& brdf) {
  return brdf.kind != BrdfKind::kLambert && brdf.specular != glm::vec3(0.0f);
}

}  // namespace multum
