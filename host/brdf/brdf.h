// SPDX-License-Identifier: Apache-2.0
// How a smooth point of the surface reflects, as plain settings: k_d / pi max(n.l, 0) + k_s f(n.h) max(n.l, 0).
#pragma once

#include <glm/vec3.hpp>

namespace multum {

enum class BrdfKind {
  kBlinnPhong,       // facets (s + 1) / (2 pi) (n.h)^s
  kTorranceSparrow,  // facets = vMF of kappa 1 / (2 sigma^2); Fresnel and shadowing are left to `specular`
};

struct Brdf {
  BrdfKind kind = BrdfKind::kBlinnPhong;
  float exponent = 100.0f;  // s, 1..1e5
  float sigma = 0.1f;       // radians, 0.002..1
  glm::vec3 diffuse{0.5f};
  glm::vec3 specular{0.1f};
};

}  // namespace multum
