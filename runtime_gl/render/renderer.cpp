// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/renderer.h"

#include <algorithm>
#include <array>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/base/error.h"
#include "host/base/stopwatch.h"
#include "runtime_gl/render/light_shading.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

// Roberts' R2 sequence: multiples of 1/g and 1/g^2, g^3 = g + 1, shifted by one half. Evenly spread for every count.
glm::vec2 jitter_offset(int sample) {
  const double x = 0.5 + 0.7548776662466927 * (sample + 1);
  const double y = 0.5 + 0.5698402909980532 * (sample + 1);
  return {static_cast<float>(x - static_cast<int>(x) - 0.5), static_cast<float>(y - static_cast<int>(y) - 0.5)};
}

void append(const ShaderParts& parts, ShaderSources& sources) {
  sources.flags.insert(sources.flags.end(), parts.flags.begin(), parts.flags.end());
  for (const std::string text : parts.texts)
    if (std::find(sources.fragment.begin(), sources.fragment.end(), text) == sources.fragment.end())
      sources.fragment.push_back(text);
}

}  // namespace

Renderer::Renderer(const GlFunctions& gl, int width, int height)
    : gl_(gl), framebuffer_(gl, width, height), sum_(gl, width, height), full_screen_(gl), environment_(gl) {}

ShaderSources scene_shader_sources(const Material& material, const RenderScene& scene) {
  ShaderSources sources{
      material.name(), {}, {shader_scene_vert}, {shader_common_movmf_shading_glsl, shader_common_reflection_glsl}};
  append(brdf_shader_parts(scene.brdf), sources);
  append(environment_shader_parts(scene, material.samples_light()), sources);
  append(material.shader_parts(), sources);
  append(light_shader_parts(scene), sources);
  sources.fragment.push_back(shader_scene_frag);
  return sources;
}

const ShaderProgram& Renderer::program(const Material& material, const RenderScene& scene) {
  const ShaderSources sources = scene_shader_sources(material, scene);
  std::string key = sources.name;
  for (const std::string& flag : sources.flags) key += "|" + flag;
  std::unique_ptr<Variant>& entry = programs_[key];
  if (entry == nullptr) entry.reset(new Variant{sources, {gl_, sources}});
  return entry->program;
}

std::vector<ShaderVariant> Renderer::variants() const {
  std::vector<ShaderVariant> variants;
  for (const auto& [key, entry] : programs_) {
    ShaderVariant& variant = variants.emplace_back();
    variant.flags = entry->sources.flags;
    for (const std::string& flag : variant.flags) variant.fragment += "#define " + flag + "\n";
    for (const std::string& text : entry->sources.fragment) variant.fragment += text;
    variant.uniforms = entry->program.active_uniforms();
  }
  return variants;
}

void Renderer::set_scene(const ShaderProgram& shader, const Material& material, const RenderScene& scene) {
  shader.set_vec3("u_eye", glm::value_ptr(scene.camera.eye), 1);
  shader.set("u_uv_scale", scene.uv_scale);
  brdf_.set(shader, scene.brdf, material.zonal_order());
  set_lights(shader, scene);
  environment_.set(shader, scene, material.samples_light(), {framebuffer_.width(), framebuffer_.height()},
                   material.bind(shader));
  check_gl(gl_, "setting the scene's uniforms");
}

void Renderer::draw_once(const ShaderProgram& shader, const Mesh& mesh, const RenderScene& scene,
                         glm::vec2 jitter) const {
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), jitter);
  shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
  framebuffer_.clear_depth();
  mesh.draw();
}

namespace {

// How long the driver drew, by its own clock.
class DrawTimer {
 public:
  explicit DrawTimer(const GlFunctions& gl) : gl_(gl) { gl_.CreateQueries(GL_TIME_ELAPSED, 1, &query_); }
  ~DrawTimer() { gl_.DeleteQueries(1, &query_); }
  DrawTimer(const DrawTimer&) = delete;
  DrawTimer& operator=(const DrawTimer&) = delete;

  void begin() const { gl_.BeginQuery(GL_TIME_ELAPSED, query_); }
  void end() const { gl_.EndQuery(GL_TIME_ELAPSED); }
  double milliseconds() const {
    GLuint64 nanoseconds = 0;
    gl_.GetQueryObjectui64v(query_, GL_QUERY_RESULT, &nanoseconds);
    return static_cast<double>(nanoseconds) * 1e-6;
  }

 private:
  const GlFunctions& gl_;
  GLuint query_ = 0;
};

}  // namespace

Picture Renderer::draw(const Mesh& mesh, const Material& material, const RenderScene& scene) {
  return draw({{&mesh, &material, scene.brdf}}, scene);
}

Picture Renderer::draw(const std::vector<SceneObject>& objects, const RenderScene& scene) {
  std::vector<RenderScene> scenes(objects.size(), scene);
  std::vector<const ShaderProgram*> shaders;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    scenes[i].brdf = objects[i].brdf;
    shaders.push_back(&program(*objects[i].material, scenes[i]));
  }
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), glm::vec2(0.0f));
  // Of one object, what does not change from frame to frame is set once.
  if (objects.size() == 1) set_scene(*shaders[0], *objects[0].material, scenes[0]);
  framebuffer_.bind();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  std::array<double, 4> times{}, draw_times{};
  DrawTimer timer(gl_);
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    gl_.Finish();
    const Stopwatch stopwatch;
    timer.begin();
    framebuffer_.clear_colour();
    framebuffer_.clear_depth();
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const ShaderProgram& shader = *shaders[i];
      if (objects.size() > 1) set_scene(shader, *objects[i].material, scenes[i]);
      shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
      shader.use();
      objects[i].mesh->draw();
    }
    timer.end();
    gl_.Finish();
    times[frame] = 1e3 * stopwatch.seconds();
    draw_times[frame] = timer.milliseconds();
  }
  check_gl(gl_, "drawing");
  for (auto* list : {&times, &draw_times}) std::sort(list->begin() + 1, list->end());  // the first compiled the shader
  return {framebuffer_.read(), times[2], draw_times[2]};
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

Picture Renderer::draw_truth(const Mesh& mesh, const Material& material, const RenderScene& scene, int sample_count,
                             Progress* progress) {
  MULTUM_CHECK(sample_count > 0);
  const ShaderProgram& shader = program(material, scene);
  if (adder_ == nullptr)
    adder_ = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{"accumulate", {}, {shader_full_screen_vert}, {shader_accumulate_frag}});
  set_scene(shader, material, scene);
  sum_.clear_colour();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Finish();
  const Stopwatch stopwatch;
  for (int i = 0; i < sample_count; ++i) {
    framebuffer_.bind();
    framebuffer_.clear_colour();
    material.bind(shader);
    if (material.samples_light()) environment_.set_sample(shader, scene, i);
    shader.use();
    draw_once(shader, mesh, scene, material.samples_footprint() ? glm::vec2(0.0f) : jitter_offset(i));
    accumulate(*adder_);
    if (progress == nullptr) continue;
    // Else samples would be counted that the driver has only queued.
    if (i % 8 == 7) gl_.Finish();
    progress->advance(1);
  }
  gl_.Finish();
  const double time = 1e3 * stopwatch.seconds();
  check_gl(gl_, "drawing the truth");
  Picture picture{sum_.read(), time};
  for (float& value : picture.image.rgba) value /= static_cast<float>(sample_count);
  return picture;
}

}  // namespace multum::gl
