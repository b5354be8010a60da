// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/renderer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/run_times.h"
#include "host/foundation/base/stopwatch.h"
#include "runtime_gl/render/light_shading.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

void append(const ShaderParts& parts, ShaderSources& sources) {
  sources.flags.insert(sources.flags.end(), parts.flags.begin(), parts.flags.end());
  for (const std::string text : parts.texts)
    if (std::find(sources.fragment.begin(), sources.fragment.end(), text) == sources.fragment.end())
      sources.fragment.push_back(text);
}

void append_filter(const TextureFilter& filter, const Material& material, ShaderSources& sources) {
  const int lobes = material.budgeted_lobes();
  const int evaluations = filter.evaluations != kEvaluationsOfLobes ? filter.evaluations
                          : lobes > 1                               ? evaluations_of_lobes(lobes)
                                                                    : 0;
  const bool samples_light = material.samples_light();  // drawn many times and averaged
  MULTUM_CHECK(filter.taps >= 1 && filter.taps <= kTapCountMax);
  MULTUM_CHECK(evaluations >= 0 && evaluations <= kEvaluationsMax);
  if (filter.is_turned && !samples_light) sources.flags.push_back("MULTUM_TURNED");
  if (filter.is_drivers) {
    sources.flags.push_back("MULTUM_DRIVER_FILTER");
    return;
  }
  if (filter.taps > 1) sources.flags.push_back("MULTUM_TAPS " + std::to_string(filter.taps));
  if (evaluations > 0 && !samples_light) {
    sources.flags.push_back("MULTUM_EVALUATIONS " + std::to_string(evaluations));
  } else if (filter.taps > 1 && filter.shades_taps) {
    sources.flags.push_back("MULTUM_SHADE_TAPS");
  }
}

}  // namespace

int evaluations_of_lobes(int lobe_count) {
  return std::min(static_cast<int>(std::bit_ceil(static_cast<unsigned>(lobe_count))), kEvaluationsMax);
}

Renderer::Renderer(const GlFunctions& gl, int width, int height)
    : gl_(gl),
      framebuffer_(gl, width, height),
      sum_(gl, width, height),
      full_screen_(gl),
      brdf_(gl),
      environment_(gl) {}

ShaderSources scene_shader_sources(const Material& material, const RenderScene& scene) {
  ShaderSources sources{material.name(),
                        {},
                        {shader_scene_vert},
                        {shader_common_movmf_shading_glsl, shader_common_evaluations_glsl,
                         shader_common_texture_filter_glsl, shader_common_reflection_glsl}};
  append_filter(scene.filter, material, sources);
  append(brdf_shader_parts(scene.brdf), sources);
  append(environment_shader_parts(scene, material.samples_light()), sources);
  append(material.shader_parts(), sources);
  if (scene.roughness != nullptr)
    append({{"MULTUM_ROUGHNESS_TEXTURE"}, {shader_surface_roughness_texture_glsl}}, sources);
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
  shader.set("u_level_bias", scene.filter.level_bias);
  const int unit = brdf_.set(shader, scene.brdf, scene.roughness, material.zonal_order(), material.bind(shader));
  set_lights(shader, scene);
  environment_.set(shader, scene, material.samples_light(), {framebuffer_.width(), framebuffer_.height()}, unit);
  check_gl(gl_, "setting the scene's uniforms");
}

void Renderer::draw_shifted(const ShaderProgram& shader, const Mesh& mesh, const RenderScene& scene,
                            glm::vec2 offset) const {
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), offset);
  shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
  framebuffer_.clear_depth();
  mesh.draw();
}

namespace {

// Measures the drawing time with the driver's own timer.
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

FloatImage Renderer::draw_once(const Mesh& mesh, const Material& material, const RenderScene& scene) {
  const ShaderProgram& shader = program(material, scene);
  set_scene(shader, material, scene);
  framebuffer_.bind();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  framebuffer_.clear_colour();
  shader.use();
  draw_shifted(shader, mesh, scene, glm::vec2(0.0f));
  check_gl(gl_, "drawing");
  return framebuffer_.read();
}

Picture Renderer::draw(const std::vector<SceneObject>& objects, const RenderScene& scene) {
  std::vector<RenderScene> scenes(objects.size(), scene);
  std::vector<const ShaderProgram*> shaders;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    scenes[i].brdf = objects[i].brdf;
    shaders.push_back(&program(*objects[i].material, scenes[i]));
  }
  const glm::mat4 matrix = view_projection(scene.camera, framebuffer_.width(), framebuffer_.height(), glm::vec2(0.0f));
  // With a single object, state that does not change from frame to frame is set once.
  if (objects.size() == 1) set_scene(*shaders[0], *objects[0].material, scenes[0]);
  framebuffer_.bind();
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  const auto draw_objects = [&] {
    framebuffer_.clear_colour();
    framebuffer_.clear_depth();
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const ShaderProgram& shader = *shaders[i];
      if (objects.size() > 1) set_scene(shader, *objects[i].material, scenes[i]);
      shader.set_mat4("u_view_projection", glm::value_ptr(matrix));
      shader.use();
      objects[i].mesh->draw();
    }
  };
  // Drivers compile a shader at its first draw, even of a single pixel.
  gl_.Enable(GL_SCISSOR_TEST);
  gl_.Scissor(0, 0, 1, 1);
  draw_objects();
  gl_.Disable(GL_SCISSOR_TEST);
  std::vector<double> times, processor_times, draw_times;
  DrawTimer timer(gl_);
  while (times.size() < kTimedFrames && (times.empty() || times.front() <= kLongFrameMs)) {
    gl_.Finish();
    const RunClock clock;
    timer.begin();
    draw_objects();
    timer.end();
    gl_.Finish();
    const RunTime time = clock.time();
    times.push_back(1e3 * time.elapsed_seconds);
    processor_times.push_back(1e3 * time.processor_seconds);
    draw_times.push_back(timer.milliseconds());
  }
  check_gl(gl_, "drawing");
  const int frame_count = static_cast<int>(times.size());
  for (auto* list : {&times, &draw_times}) std::sort(list->begin(), list->end());
  const std::size_t middle = times.size() / 2;
  Picture picture{framebuffer_.read(), times[middle]};
  picture.processor_time_ms = *std::min_element(processor_times.begin(), processor_times.end());
  picture.draw_time_ms = draw_times[middle];
  picture.frame_count = frame_count;
  return picture;
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

Picture Renderer::draw_reference(const Mesh& mesh, const Material& material, const RenderScene& scene,
                                 const ReferenceSampling& sampling, Progress* progress) {
  MULTUM_CHECK(sampling.sample_count >= 0 && sampling.sample_count <= kReferenceSampleCountMax);
  MULTUM_CHECK(sampling.sample_count > 0 || sampling.noise_max > 0.0);
  const ShaderProgram& shader = program(material, scene);
  if (adder_ == nullptr)
    adder_ = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{"accumulate", {}, {shader_full_screen_vert}, {shader_accumulate_frag}});
  set_scene(shader, material, scene);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Finish();
  const Stopwatch stopwatch;
  const bool is_fixed = sampling.sample_count > 0;
  // The noise can be measured only from the second batch on.
  const int batch = is_fixed ? std::min(kReferenceBatch, (sampling.sample_count + 1) / 2) : kReferenceBatch;
  const int count_max = is_fixed ? sampling.sample_count : kReferenceSampleCountMax;
  const int direction_count = environment_sample_count(sampling.sample_count);
  ReferenceSum sum(framebuffer_.width(), framebuffer_.height());
  double share_done = 0.0;
  for (int begin = 0; begin < count_max;) {
    const int end = std::min(begin + batch, count_max);
    sum_.clear_colour();
    for (int i = begin; i < end; ++i) {
      framebuffer_.bind();
      framebuffer_.clear_colour();
      material.bind(shader);
      if (material.samples_light()) environment_.set_sample(shader, scene, i, direction_count);
      shader.use();
      draw_shifted(shader, mesh, scene,
                   material.samples_footprint() ? glm::vec2(0.0f) : reference_offset(sampling.filter, i));
      accumulate(*adder_);
    }
    sum.add(sum_.read(), end - begin);
    const bool is_pair = (end / batch) % 2 == 0 || end == count_max;
    begin = end;
    const double noise = sum.noise();
    const bool is_done = end == count_max || (!is_fixed && is_pair && noise <= sampling.noise_max);
    // The noise decreases approximately with the power -3/4 of the sample count.
    const double share = is_done    ? 1.0
                         : is_fixed ? static_cast<double>(end) / count_max
                                    : std::min(0.99, std::pow(sampling.noise_max / noise, 4.0 / 3.0));
    const auto units = static_cast<std::uint64_t>(kReferenceUnits * std::max(share, share_done)) -
                       static_cast<std::uint64_t>(kReferenceUnits * share_done);
    share_done = std::max(share, share_done);
    progress_advance(progress, units);
    if (is_done) break;
  }
  const double time = 1e3 * stopwatch.seconds();
  check_gl(gl_, "drawing the reference");
  Picture picture{sum.mean(), time};
  picture.sample_count = sum.sample_count();
  picture.noise = sum.noise();
  return picture;
}

}  // namespace multum::gl
