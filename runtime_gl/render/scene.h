// SPDX-License-Identifier: Apache-2.0
// Defines the settings of a scene: its camera, lights, environment, BRDF and texture filter.
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

constexpr int kLightCountMax = 8;  // limit for each kind of light

struct Light {
  glm::vec3 direction{0.3f, 0.8f, 0.5f};  // towards the light, any length > 0
  glm::vec3 irradiance{3.14159265f};      // irradiance on a facing surface
};

struct PointLight {
  glm::vec3 position{0.0f, 0.0f, 1.0f};
  glm::vec3 intensity{1.0f};  // irradiance on a facing surface at distance 1
};

/// Methods for the highlight of lobes under an environment.
enum class EnvironmentMode {
  kHarmonics,    // Han et al. 2007, section 8, to order 8
  kPrefiltered,  // mips convolved with vMFs, chosen by the spread of the reflected directions
};

/// Settings for lookups of mip-mapped textures over a pixel (shaders/common/texture_filter.glsl).
/// docs/evidence/FILTER.md explains the defaults.
struct TextureFilter {
  int taps = kTapCountDefault;  // most trilinear lookups along the longer axis, 1 to kTapCountMax
  float level_bias = static_cast<float>(kLevelBiasDefault);  // added to the level of detail
  bool shades_taps = kShadesTapsDefault;  // shades each tap separately; if false, averages the taps and shades once
  bool is_drivers = false;                // uses the driver's own sampler instead, with its anisotropy and no bias
  int evaluations = 0;  // evaluations of the material per pixel: a power of two up to kEvaluationsMax, 0 to use taps as
                        // above, or kEvaluationsOfLobes
  bool is_turned = false;  // the geometry's normals turn within a pixel, as on a mesh (shaders/scene.frag)
};

constexpr int kEvaluationsMax = 16;
constexpr int kEvaluationsOfLobes = -1;  // means evaluations_of_lobes(Material::budgeted_lobes()), or 0 for fewer than
                                         // two lobes

/// Returns the number of evaluations per pixel if each lobe is evaluated once. This is the next power of two, but at
/// most kEvaluationsMax.
int evaluations_of_lobes(int lobe_count);

/// Perceptual roughness, 0 to 1, over the same coordinates as the map. Row 0 is at the top.
struct RoughnessMap {
  int width = 1, height = 1;
  std::vector<float> texels;
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;
};

struct RenderScene {
  Camera camera;
  std::vector<Light> lights = std::vector<Light>(1);
  std::vector<PointLight> point_lights;
  std::shared_ptr<const EnvironmentLight> environment;  // null means none
  EnvironmentMode environment_mode = EnvironmentMode::kPrefiltered;
  glm::vec3 environment_up{0.0f, 0.0f, 1.0f};  // unit, the map's up direction; with +Z, the map's middle is at +Y
  float environment_turn = 0.0f;               // degrees about `environment_up`, counterclockwise seen from above
  Brdf brdf;
  std::shared_ptr<const RoughnessMap> roughness;  // factor of the BRDF's GGX roughness under lights; null means 1
  TextureFilter filter;
  float uv_scale = 1.0f;  // repeats of the map per unit of uv
};

}  // namespace multum::gl
