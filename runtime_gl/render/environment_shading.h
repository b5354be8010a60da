// SPDX-License-Identifier: Apache-2.0
// A scene's environment in a shader: its maps, and the tables that go with the BRDF and the camera.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/kept_of_brdf.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// Directions that a pixel's environment is sampled in, of each kind, where there is one normal a sample.
constexpr int kEnvironmentSampleCount = 32;

/// The environment's x, y and z in the world: y is up; -z, the map's middle, is ahead of who looks over the plane z = 0
/// along y, or at a mesh from the front; then all are turned by the scene's environment_turn.
std::array<glm::vec3, 3> environment_axes(const RenderScene& scene);

/// `samples_light`: that of the material. Nothing without an environment.
ShaderParts environment_shader_parts(const RenderScene& scene, bool samples_light);

class EnvironmentShading {
 public:
  explicit EnvironmentShading(const GlFunctions& gl) : gl_(&gl) {}

  /// Gives textures units from `unit` on. Keeps what is still right from the call before.
  void set(const ShaderProgram& shader, const RenderScene& scene, bool samples_light, glm::ivec2 viewport, int unit);

  /// Of what samples light: the directions of the picture's sample number `sample`.
  void set_sample(const ShaderProgram& shader, const RenderScene& scene, int sample) const;

  /// Processor time of set() since the last call: what an environment or a camera that changes costs besides drawing.
  double take_processor_seconds() { return std::exchange(processor_seconds_, 0.0); }

 private:
  void set_parts(const ShaderProgram& shader, const RenderScene& scene, bool samples_light, glm::ivec2 viewport,
                 int unit);
  void set_map(const RenderScene& scene);
  // What lobes reflect of an environment by a BRDF.
  struct Tables {
    std::vector<float> term_spreads;
    std::optional<Texture> texture;     // none of Lambert
    std::vector<glm::vec3> half_zonal;  // to kHalfVectorOrder, where asked for
  };
  Tables make_tables(const Brdf& brdf) const;
  void set_half_vector_light(const RenderScene& scene, glm::ivec2 viewport);

  const GlFunctions* gl_;
  std::shared_ptr<const EnvironmentLight> light_;  // what map_ holds
  std::optional<Texture> map_;
  KeptOfBrdf<Tables> tables_;
  std::optional<Texture> half_vector_light_;
  double processor_seconds_ = 0.0;
};

}  // namespace multum::gl
