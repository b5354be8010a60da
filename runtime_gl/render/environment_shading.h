// SPDX-License-Identifier: Apache-2.0
// Defines the environment of a scene in a shader by its maps, and by the tables for the BRDF and the camera.
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

/// The largest number of directions of each kind in which a pixel's sample takes light from its environment, if each
/// sample has one normal.
constexpr int kEnvironmentSampleCount = 32;

/// Returns the number of directions of each kind per sample, for a picture of `sample_count` samples per pixel, or an
/// unknown number of them (0). Samples of a pixel differ in their normals, so many samples with few directions have
/// less noise than few samples with many directions. 8 directions instead of 32 take a third of the time, and the noise
/// of 32 samples increases by a twentieth (measured with the demo's materials).
int environment_sample_count(int sample_count);

/// Returns the environment's x, y and z axes in the world. y is up. The map's middle, -z, is straight ahead for a
/// viewer who looks along y over the plane z = 0, or who looks at a mesh from the front. The scene's environment_turn
/// then rotates all axes.
std::array<glm::vec3, 3> environment_axes(const RenderScene& scene);

/// `samples_light` is the result of Material::samples_light(). Returns an empty ShaderParts if there is no environment.
ShaderParts environment_shader_parts(const RenderScene& scene, bool samples_light);

class EnvironmentShading {
 public:
  explicit EnvironmentShading(const GlFunctions& gl) : gl_(&gl) {}

  /// Binds textures to units from `unit` on. Reuses data of the last call that is still valid.
  void set(const ShaderProgram& shader, const RenderScene& scene, bool samples_light, glm::ivec2 viewport, int unit);

  /// Sets the directions of sample number `sample` of the picture, `count` of each kind, for materials that sample
  /// light. `count` is 1 to kEnvironmentSampleCount.
  void set_sample(const ShaderProgram& shader, const RenderScene& scene, int sample, int count) const;

  /// Returns the processor time of set() since the last call. A changing environment or camera costs this time in
  /// addition to drawing.
  double take_processor_seconds() { return std::exchange(processor_seconds_, 0.0); }

 private:
  void set_parts(const ShaderProgram& shader, const RenderScene& scene, bool samples_light, glm::ivec2 viewport,
                 int unit);
  void set_map(const RenderScene& scene);
  // The light of an environment that lobes reflect with a BRDF.
  struct Tables {
    std::vector<float> term_spreads;
    std::optional<Texture> texture;     // none for Lambert
    std::vector<glm::vec3> half_zonal;  // orders up to kHalfVectorOrder, if these were requested
  };
  Tables make_tables(const Brdf& brdf) const;
  void set_half_vector_light(const RenderScene& scene, glm::ivec2 viewport);

  const GlFunctions* gl_;
  std::shared_ptr<const EnvironmentLight> light_;  // the environment in map_
  std::optional<Texture> map_;
  KeptOfBrdf<Tables> tables_;
  std::optional<Texture> half_vector_light_;
  double processor_seconds_ = 0.0;
};

}  // namespace multum::gl
