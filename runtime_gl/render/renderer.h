// SPDX-License-Identifier: Apache-2.0
// Draws a mesh under a camera into a linear float picture: the baked map, the ground truth, or a baseline.
// Deterministic: same input, same bytes on one device.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

enum class Baseline { kMip, kToksvig, kLean, kLeanJacobian };

struct Picture {
  FloatImage image;
  double frame_time_ms;  // glFinish to glFinish of one frame, the median of 3 after a first one; truth: all passes
};

class Renderer {
 public:
  Renderer(const GlFunctions& gl, int width, int height);

  Picture draw_movmf(const Mesh& mesh, const MovmfMaterial& material, const Scene& scene, LobeFormula formula);
  /// Of a file of moments, shaded as draw_baseline() shades what is averaged on the spot.
  Picture draw_moments(const Mesh& mesh, const MomentMaterial& material, const Scene& scene, MomentShading shading);
  Picture draw_baseline(const Mesh& mesh, const NormalMaterial& material, const Scene& scene, Baseline baseline);
  /// The mean of `sample_count` pictures of unfiltered normals, each shifted by a fraction of a pixel (low-discrepancy
  /// sequence, box filter of one pixel): cosines and BRDF evaluated at every sample's own normal.
  Picture draw_truth(const Mesh& mesh, const NormalMaterial& material, const Scene& scene, int sample_count);

 private:
  const ShaderProgram& program(const std::string& name, const std::vector<std::string>& flags);
  void accumulate(const ShaderProgram& adder) const;
  void set_scene(const ShaderProgram& shader, const Scene& scene) const;
  void draw_once(const ShaderProgram& shader, const Mesh& mesh, const Scene& scene, glm::vec2 jitter) const;
  Picture draw_timed(const ShaderProgram& shader, const Mesh& mesh, const Scene& scene) const;

  const GlFunctions& gl_;
  Framebuffer framebuffer_;
  Framebuffer sum_;
  EmptyMesh full_screen_;
  std::map<std::string, std::unique_ptr<ShaderProgram>> programs_;
  std::unique_ptr<ShaderProgram> adder_;
};

}  // namespace multum::gl
