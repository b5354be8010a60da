// SPDX-License-Identifier: Apache-2.0
// Describes what is drawn and how, as plain settings.
#pragma once

#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/tap_filter.h"
#include "host/formats/brdf/brdf.h"
#include "host/formats/light/environment_light.h"
#include "host/foundation/base/wrap_mode.h"
#include "runtime_gl/render/camera.h"

namespace multum::gl {

constexpr int kLightCountMax = 8;  // of each kind

struct Light {
  glm::vec3 direction{0.3f, 0.8f, 0.5f};  // towards the light, any length > 0
  glm::vec3 irradiance{3.14159265f};      // on a surface that faces it
};

struct PointLight {
  glm::vec3 position{0.0f, 0.0f, 1.0f};
  glm::vec3 intensity{1.0f};  // irradiance at distance 1 of a surface that faces it
};

/// How lobes take the highlight of an environment.
enum class EnvironmentMode {
  kHarmonics,    // Han et al. 2007, section 8, to order 8
  kPrefiltered,  // mips convolved with vMFs, by the spread of what is reflected
};

/// How mip-mapped textures are looked up over a pixel (shaders/common/texture_filter.glsl). Defaults:
/// docs/evidence/FILTER.md.
struct TextureFilter {
  int taps = kTapCountDefault;  // trilinear lookups along the longer axis at most, 1..kTapCountMax
  float level_bias = static_cast<float>(kLevelBiasDefault);  // added to the level of detail
  bool shades_taps = kShadesTapsDefault;  // each tap is shaded by itself; else what they return is averaged first
  bool is_drivers = false;                // the driver's own sampler instead: its anisotropy, no bias
  int evaluations = 0;     // of the material in a pixel, a power of two, 1..kEvaluationsMax; 0: by taps, as above;
                           // kEvaluationsOfLobes
  bool is_turned = false;  // normals turn within a pixel, as a mesh's do: shaders/scene.frag
};

constexpr int kEvaluationsMax = 16;
constexpr int kEvaluationsOfLobes = -1;  // evaluations_of_lobes(Material::budgeted_lobes()); 0 of less than two lobes

/// So many of lobes that are evaluated once each: the next power of two, kEvaluationsMax at most.
int evaluations_of_lobes(int lobe_count);

/// Perceptual roughness, 0..1, row 0 on top; over the same coordinates as the map.
struct RoughnessMap {
  int width = 1, height = 1;
  std::vector<float> texels;
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;
};

struct RenderScene {
  Camera camera;
  std::vector<Light> lights = std::vector<Light>(1);
  std::vector<PointLight> point_lights;
  std::shared_ptr<const EnvironmentLight> environment;  // null: none
  EnvironmentMode environment_mode = EnvironmentMode::kPrefiltered;
  glm::vec3 environment_up{0.0f, 0.0f, 1.0f};  // unit; what lies up in the map. With +Z, its middle lies along +Y
  float environment_turn = 0.0f;               // degrees about `environment_up`, counterclockwise as seen from there
  Brdf brdf;
  std::shared_ptr<const RoughnessMap> roughness;  // of GGX, times the BRDF's own, under lights; null: that alone
  TextureFilter filter;
  float uv_scale = 1.0f;  // repeats of the map per unit of uv
};

}  // namespace multum::gl
