// SPDX-License-Identifier: Apache-2.0
// Draws a mesh with the baked map, the reference or a baseline, as a camera sees it, into a linear float picture.
// Drawing is deterministic: the same input gives the same bytes on one device.
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
  // The time of one frame, measured from one glFinish to the next. It is the median of 3 frames, or the time of the
  // first frame if this took longer than kLongFrameMs. For a reference, it is the time of all samples.
  double frame_time_ms;
  double processor_time_ms = 0.0;  // lowest processor time of these frames, over all threads of this process; 0 for a
                                   // reference
  double draw_time_ms = 0.0;       // drawing time by the driver's own timer (GL_TIME_ELAPSED); 0 for a reference
  int sample_count = 0;            // samples per pixel of a reference
  double noise = 0.0;              // noise of a reference (ReferenceSum::noise)
  int frame_count = 1;             // whole frames drawn for this picture
};

/// One of several objects in a picture.
struct SceneObject {
  const Mesh* mesh;
  const Material* material;
  Brdf brdf;  // replaces the scene's BRDF
};

/// A compiled shader, and those of its uniforms that the driver did not remove.
struct ShaderVariant {
  std::vector<std::string> flags;
  std::string fragment;  // the flags as #define, then every text
  std::vector<std::string> uniforms;
};

/// Returns the fragment shader of a material, a BRDF and lights. The shader has the flags of all parts, and each text
/// only once.
ShaderSources scene_shader_sources(const Material& material, const RenderScene& scene);

constexpr int kTimedFrames = 3;        // frames that Renderer::draw times, an odd number
constexpr double kLongFrameMs = 10.0;  // longer frames are timed only once, because some take seconds in software
constexpr int kReferenceUnits = 1000;  // units of progress per reference picture

class Renderer {
 public:
  Renderer(const GlFunctions& gl, int width, int height);

  /// Compiles the shader for the material, the BRDF and the lights when they are first used together.
  Picture draw(const Mesh& mesh, const Material& material, const RenderScene& scene);
  Picture draw(const std::vector<SceneObject>& objects, const RenderScene& scene);
  /// Draws the same picture once, without timing.
  FloatImage draw_once(const Mesh& mesh, const Material& material, const RenderScene& scene);
  /// Returns the mean of many pictures, each shifted by a fraction of a pixel. For the normals of the finest level,
  /// this evaluates the BRDF with every sample's own normal. Counts kReferenceUnits in `progress`.
  Picture draw_reference(const Mesh& mesh, const Material& material, const RenderScene& scene,
                         const ReferenceSampling& sampling, Progress* progress = nullptr);
  /// Returns the variants of everything drawn so far, except the shader that adds up pictures.
  std::vector<ShaderVariant> variants() const;
  /// Returns EnvironmentShading::take_processor_seconds().
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
