// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/shader_harness.h"

#include <limits>

#include "host/foundation/base/error.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

std::vector<glm::vec4> evaluate_shader(const GlFunctions& gl, const ShaderHarnessInput& input) {
  MULTUM_CHECK(!input.a.empty() && input.a.size() == input.b.size());
  const int count = static_cast<int>(input.a.size());
  const SamplerSettings nearest{WrapMode::kClamp, WrapMode::kClamp, false, 1.0f};
  Texture a(gl, "input a", {count, 1, 1, TexelFormat::kRgba32f}, nearest);
  Texture b(gl, "input b", {count, 1, 1, TexelFormat::kRgba32f}, nearest);
  a.upload_level(0, &input.a[0].x);
  b.upload_level(0, &input.b[0].x);
  const std::string inputs =
      "uniform sampler2D u_a;\nuniform sampler2D u_b;\nuniform sampler2D map;\nlayout(location = 0) out vec4 o;\n";
  const std::string main =
      "float multum_vmf_eighth_zonal(float kappa) {\n  float zonal[9];\n  multum_vmf_zonal(kappa, zonal);\n"
      "  return zonal[8];\n}\n"
      "void main() {\n  ivec2 p = ivec2(gl_FragCoord.xy);\n  vec4 a = texelFetch(u_a, p, 0);\n"
      "  vec4 b = texelFetch(u_b, p, 0);\n  o = " +
      input.expression + ";\n}\n";
  const std::string formulas =
      edited_source(std::string(shader_common_movmf_shading_glsl) + shader_common_texture_filter_glsl +
                        shader_common_reflection_glsl + brdf_shader_text("blinn_phong.glsl") +
                        brdf_shader_text("torrance_sparrow.glsl") + brdf_shader_text("cook_torrance.glsl") +
                        brdf_shader_text("ggx.glsl") + brdf_shader_text("terms.glsl") + shader_common_vmf_zonal_glsl +
                        shader_common_gmm_shading_glsl + shader_common_moment_shading_glsl + input.formulas,
                    kGlslFormulas, input.edits);
  const ShaderProgram program(gl, {"harness", input.flags, {shader_full_screen_vert}, {inputs, formulas, main}});
  program.set("u_a", 0);
  program.set("u_b", 1);
  program.set("map", 2);
  const Framebuffer framebuffer(gl, count, 1);
  const EmptyMesh full_screen(gl);
  framebuffer.bind();
  framebuffer.clear_colour(std::numeric_limits<float>::quiet_NaN());
  gl.Disable(GL_DEPTH_TEST);
  gl.Disable(GL_BLEND);
  a.bind(0);
  b.bind(1);
  if (input.texture != nullptr) input.texture->bind(2);
  program.use();
  if (input.set_uniforms) input.set_uniforms(program);
  full_screen.draw_triangle();
  check_gl(gl, "evaluating " + input.expression);
  const FloatImage image = framebuffer.read();
  std::vector<glm::vec4> values;
  for (std::size_t i = 0; i < input.a.size(); ++i)
    values.emplace_back(image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2], image.rgba[4 * i + 3]);
  return values;
}

}  // namespace multum::gl
