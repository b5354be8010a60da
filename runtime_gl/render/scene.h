// SPDX-License-Identifier: Apache-2.0
// What is drawn and how, as plain settings.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "runtime_gl/render/camera.h"

namespace multum::gl {

constexpr int kLightCountMax = 8;

struct Light {
  glm::vec3 direction{0.3f, 0.8f, 0.5f};  // towards the light, any length > 0
  glm::vec3 irradiance{3.14159265f};      // on a surface that faces it
};

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

struct Scene {
  Camera camera;
  std::vector<Light> lights{Light{}};
  Brdf brdf;
  float uv_scale = 1.0f;  // repeats of the map per unit of uv
};

enum class LobeFormula {
  kProduct,  // mean cosines multiplied (docs/ALGORITHMS.md)
  kPaper,    // Han et al. 2007, equation 20 and Algorithm 2
};

}  // namespace multum::gl
