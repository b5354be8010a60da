// SPDX-License-Identifier: Apache-2.0
// Draws a mesh under a camera into a linear float picture: the baked map, the reference, or a baseline.
// Deterministic: same input, same bytes on one device.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/brdf_shading.h"
#include "runtime_gl/render/environment_shading.h"
#include "runtime_gl/render/reference_sampling.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

struct Picture {
  FloatImage image;
  // glFinish to glFinish of one frame: the median of 3, or one frame that took longer than kLongFrameMs. Of a
  // reference: all samples
  double frame_time_ms;
  double processor_time_ms = 0.0;  // of this process in such a frame, in all its threads: the least; reference: 0
  double draw_time_ms = 0.0;       // what the driver's own clock says that drawing took (GL_TIME_ELAPSED); reference: 0
  int sample_count = 0;            // of a reference, per pixel
  double noise = 0.0;              // of a reference (ReferenceSum::noise)
  int frame_count = 1;             // whole frames that were drawn for it
};

/// One of several things in a picture.
struct SceneObject {
  const Mesh* mesh;
  const Material* material;
  Brdf brdf;  // in the place of the scene's
};

/// A shader that was compiled, and what of it the driver kept.
struct ShaderVariant {
  std::vector<std::string> flags;
  std::string fragment;  // the flags as #define, then every text
  std::vector<std::string> uniforms;
};

/// The fragment shader of a material, a BRDF and lights: each text once, and the flags of all.
ShaderSources scene_shader_sources(const Material& material, const RenderScene& scene);

constexpr int kTimedFrames = 3;        // of Renderer::draw, an odd number
constexpr double kLongFrameMs = 10.0;  // a longer frame is timed once: software takes seconds for some
constexpr int kReferenceUnits = 1000;  // of progress, per reference picture

class Renderer {
 public:
  Renderer(const GlFunctions& gl, int width, int height);

  /// Compiles what the material, the BRDF and the lights need, the first time that they meet.
  Picture draw(const Mesh& mesh, const Material& material, const RenderScene& scene);
  Picture draw(const std::vector<SceneObject>& objects, const RenderScene& scene);
  /// The same picture, drawn once and not timed.
  FloatImage draw_once(const Mesh& mesh, const Material& material, const RenderScene& scene);
  /// The mean of many pictures, each shifted by a fraction of a pixel. Of the finest map's normals: the BRDF at every
  /// sample's own normal. Counts kReferenceUnits in `progress`.
  Picture draw_reference(const Mesh& mesh, const Material& material, const RenderScene& scene,
                         const ReferenceSampling& sampling, Progress* progress = nullptr);
  /// Of all that was drawn, but for how pictures are added up.
  std::vector<ShaderVariant> variants() const;
  /// EnvironmentShading::take_processor_seconds().
  double take_environment_seconds() { return environment_.take_processor_seconds(); }

 private:
  struct Variant {
    ShaderSources sources;
    ShaderProgram program;
  };
  const ShaderProgram& program(const Material& material, const RenderScene& scene);
  void accumulate(const ShaderProgram& adder) const;
  void set_scene(const ShaderProgram& shader, const Material& material, const RenderScene& scene);
  void draw_shifted(const ShaderProgram& shader, const Mesh& mesh, const RenderScene& scene, glm::vec2 offset) const;

  const GlFunctions& gl_;
  Framebuffer framebuffer_;
  Framebuffer sum_;
  EmptyMesh full_screen_;
  BrdfShading brdf_;
  EnvironmentShading environment_;
  std::map<std::string, std::unique_ptr<Variant>> programs_;
  std::unique_ptr<ShaderProgram> adder_;
};

}  // namespace multum::gl
