// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/base/error.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

double now_ms() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
}

// Roberts' R2 sequence: multiples of 1/g and 1/g^2, g^3 = g + 1, shifted by one half. Evenly spread for every count.
glm::vec2 jitter_offset(int sample) {
  const double x = 0.5 + 0.7548776662466927 * (sample + 1);
  const double y = 0.5 + 0.5698402909980532 * (sample + 1);
  return {static_cast<float>(x - static_cast<int>(x) - 0.5), static_cast<float>(y - static_cast<int>(y) - 0.5)};
}

std::vector<std::string> with_brdf(std::vector<std::string> flags, const Scene& scene, bool has_colours) {
  if (scene.brdf.kind == BrdfKind::kTorranceSparrow) flags.push_back("MULTUM_TORRANCE_SPARROW");
  if (has_colours) flags.push_back("MULTUM_COLOURS");
  return flags;
}

std::vector<std::string> baseline_flags(Baseline baseline) {
  switch (baseline) {
    case Baseline::kMip: return {"MULTUM_MIP"};
    case Baseline::kToksvig: return {"MULTUM_TOKSVIG"};
    case Baseline::kLean: return {"MULTUM_LEAN"};
    case Baseline::kLeanJacobian: return {"MULTUM_LEAN", "MULTUM_JACOBIAN"};
  }
  return {};
}

// As NormalMaterial and MomentMaterial bind them.
void set_baseline_units(const ShaderProgram& shader) {
  shader.set("u_normals", 0);
  shader.set("u_slopes", 1);
  shader.set("u_albedo", 2);
  shader.set("u_normal_map", 3);
  shader.set("u_albedo_map", 4);
}

}  // namespace

Renderer::Renderer(const GlFunctions& gl, int width, int height)
    : gl_(gl), framebuffer_(gl, width, height), sum_(gl, width, height), full_screen_(gl) {}

const ShaderProgram& Renderer::program(const std::string& name, const std::vector<std::string>& flags) {
  std::string key = name;
  for (const std::string& flag : flags) key += "|" + flag;
  std::unique_ptr<ShaderProgram>& entry = programs_[key];
  if (entry == nullptr)
    entry = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{name,
                           flags,
                           {shader_scene_vert},
                           {shader_common_movmf_shading_glsl, shader_common_moment_shading_glsl, shader_scene_frag}});
  return *entry;
}

void Renderer::set_scene(const ShaderProgram& shader, const Scene& scene) const {
  MULTUM_CHECK(scene.lights.size() <= kLightCountMax);
  std::array<glm::vec3, kLightCountMax> directions{};
  std::array<glm::vec3, kLightCountMax> irradiances{};
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    directions[i] = glm::normalize(scene.lights[i].direction);
    irradiances[i] = scene.lights[i].irradiance;
  }
  const bool is_torrance = scene.brdf.kind == BrdfKind::kTorranceSparrow;
  const float exponent = is_torrance ? 0.5f / (scene.brdf.sigma * scene.brdf.sigma) : scene.brdf.exponent;
  shader.set_vec3("u_eye", glm::value_ptr(scene.camera.eye), 1);
  shader.set("u_light_count", static_cast<int>(scene.lights.size()));
  shader.set_vec3("u_light_directions", glm::value_ptr(directions[0]), kLightCountMax);
  shader.set_vec3("u_light_irradiances", glm::value_ptr(irradiances[0]), kLightCountMax);
  shader.set_vec3("u_diffuse", glm::value_ptr(scene.brdf.diffuse), 1);
  shader.set_vec3("u_specular", glm::value_ptr(scene.brdf.specular), 1);
  shader.set("u_exponent", exponent);
  shader.set("u_sigma", scene.brdf.sigma);
  shader.set("u_uv_scale", scene.uv_scale);
  check_gl(gl_, "setting the scene's uniforms");
}

void Renderer::draw_once(const ShaderProgram& shader, const Mesh& mesh, const Scene& scene, glm::vec2 jitter) const {
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), jitter);
  shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
  framebuffer_.clear_depth();
  mesh.draw();
}

Picture Renderer::draw_timed(const ShaderProgram& shader, const Mesh& mesh, const Scene& scene) const {
  set_scene(shader, scene);
  framebuffer_.bind();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  shader.use();
  std::array<double, 4> times{};
  for (double& time : times) {
    gl_.Finish();
    const double begin = now_ms();
    framebuffer_.clear_colour();
    draw_once(shader, mesh, scene, glm::vec2(0.0f));
    gl_.Finish();
    time = now_ms() - begin;
  }
  check_gl(gl_, "drawing");
  std::sort(times.begin() + 1, times.end());  // the first one compiled the shader
  return {framebuffer_.read(), times[2]};
}

Picture Renderer::draw_movmf(const Mesh& mesh, const MovmfMaterial& material, const Scene& scene, LobeFormula formula) {
  std::vector<std::string> flags = {"MULTUM_MOVMF", "MULTUM_LOBE_COUNT " + std::to_string(material.lobe_count())};
  if (formula == LobeFormula::kPaper) flags.push_back("MULTUM_PAPER");
  if (material.has_normal_map()) flags.push_back("MULTUM_NORMAL_MAP");
  if (material.has_albedo_map()) flags.push_back("MULTUM_ALBEDO_MAP");
  const ShaderProgram& shader = program("movmf", with_brdf(flags, scene, material.has_colours()));
  const int lobe_count = material.lobe_count();
  shader.set_units("u_lobes", 0, lobe_count);
  if (material.has_colours()) shader.set_units("u_colours", lobe_count, lobe_count);
  const int unit = material.has_colours() ? 2 * lobe_count : lobe_count;
  shader.set("u_normal_map", unit);
  shader.set("u_albedo_map", unit + 1);
  material.bind();
  return draw_timed(shader, mesh, scene);
}

Picture Renderer::draw_moments(const Mesh& mesh, const MomentMaterial& material, const Scene& scene,
                               MomentShading shading) {
  const Baseline baseline = shading == MomentShading::kToksvig ? Baseline::kToksvig
                            : shading == MomentShading::kLean  ? Baseline::kLean
                                                               : Baseline::kLeanJacobian;
  std::vector<std::string> flags = baseline_flags(baseline);
  if (material.has_normal_map()) flags.push_back("MULTUM_NORMAL_MAP");
  if (material.has_albedo_map()) flags.push_back("MULTUM_ALBEDO_MAP");
  const ShaderProgram& shader = program("moments", with_brdf(std::move(flags), scene, material.has_colours()));
  set_baseline_units(shader);
  material.bind();
  return draw_timed(shader, mesh, scene);
}

Picture Renderer::draw_baseline(const Mesh& mesh, const NormalMaterial& material, const Scene& scene,
                                Baseline baseline) {
  const ShaderProgram& shader = program("baseline", with_brdf(baseline_flags(baseline), scene, material.has_albedo()));
  set_baseline_units(shader);
  material.bind();
  return draw_timed(shader, mesh, scene);
}

void Renderer::accumulate(const ShaderProgram& adder) const {
  sum_.bind();
  framebuffer_.bind_colour(0);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Enable(GL_BLEND);
  gl_.BlendFunc(GL_ONE, GL_ONE);
  adder.use();
  full_screen_.draw_triangle();
  gl_.Disable(GL_BLEND);
  gl_.Enable(GL_DEPTH_TEST);
}

Picture Renderer::draw_truth(const Mesh& mesh, const NormalMaterial& material, const Scene& scene, int sample_count) {
  MULTUM_CHECK(sample_count > 0);
  const ShaderProgram& shader = program("truth", with_brdf({"MULTUM_TRUTH"}, scene, material.has_albedo()));
  if (adder_ == nullptr)
    adder_ = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{"accumulate", {}, {shader_full_screen_vert}, {shader_accumulate_frag}});
  shader.set("u_normals", 0);
  shader.set("u_albedo", 2);
  set_scene(shader, scene);
  sum_.clear_colour();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Finish();
  const double begin = now_ms();
  for (int i = 0; i < sample_count; ++i) {
    framebuffer_.bind();
    framebuffer_.clear_colour();
    material.bind();
    shader.use();
    draw_once(shader, mesh, scene, jitter_offset(i));
    accumulate(*adder_);
  }
  gl_.Finish();
  const double time = now_ms() - begin;
  check_gl(gl_, "drawing the truth");
  Picture picture{sum_.read(), time};
  for (float& value : picture.image.rgba) value /= static_cast<float>(sample_count);
  return picture;
}

}  // namespace multum::gl
