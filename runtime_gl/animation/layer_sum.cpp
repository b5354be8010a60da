// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/animation/layer_sum.h"

#include <algorithm>

#include "host/foundation/base/error.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

// The number of images per pass. Every GL 4.5 has 16 texture units, and the sum of earlier passes uses one.
constexpr std::size_t kImagesMax = 8;

constexpr SamplerSettings kFetched = {WrapMode::kClamp, WrapMode::kClamp, false, 1.0f};

}  // namespace

LayerSum::LayerSum(const GlFunctions& gl, int width_max, int height_max)
    : gl_(gl), sum_(gl, "sum of images", {width_max, height_max, 1, TexelFormat::kRgba32f}, kFetched) {
  gl.CreateFramebuffers(1, &framebuffer_);
  gl.CreateVertexArrays(1, &vertex_array_);
}

LayerSum::~LayerSum() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
}

std::size_t LayerSum::memory_bytes(int width_max, int height_max) {
  return 16 * static_cast<std::size_t>(width_max) * static_cast<std::size_t>(height_max);
}

const ShaderProgram& LayerSum::program(const std::vector<std::string>& flags) {
  std::unique_ptr<ShaderProgram>& entry = programs_[flags];
  if (entry == nullptr)
    entry = std::make_unique<ShaderProgram>(
        gl_, ShaderSources{"layer sum", flags, {shader_full_screen_vert}, {shader_layer_sum_frag}});
  return *entry;
}

void LayerSum::draw(GLuint texture, int level, int width, int height) {
  gl_.NamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, texture, level);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.Viewport(0, 0, width, height);
  gl_.BindVertexArray(vertex_array_);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void LayerSum::add_up(const std::vector<WeighedTexture>& images, const std::array<float, 3>& offset,
                      const Texture& target) {
  const TextureShape& shape = target.shape();
  MULTUM_CHECK(shape.width <= sum_.shape().width && shape.height <= sum_.shape().height);
  gl_.Disable(GL_DEPTH_TEST);
  std::size_t done = 0;
  do {
    const std::size_t count = std::min(kImagesMax, images.size() - done);
    const bool is_first = done == 0, is_last = done + count == images.size();
    std::vector<std::string> flags = {"MULTUM_IMAGE_COUNT " + std::to_string(count)};
    if (is_last) flags.emplace_back("MULTUM_IS_LAST");
    if (is_last && !is_first) flags.emplace_back("MULTUM_HAS_SUM");
    const ShaderProgram& shader = program(flags);
    shader.use();
    const std::array<float, 3> none{};
    shader.set_vec3("u_offset", is_first ? offset.data() : none.data(), 1);
    std::vector<float> weights;
    for (std::size_t i = 0; i < count; ++i) {
      weights.push_back(images[done + i].weight);
      images[done + i].image->bind(static_cast<int>(i));
    }
    shader.set_units("u_images", 0, static_cast<int>(count));
    if (count > 0) shader.set_floats("u_weights", weights.data(), static_cast<int>(count));
    if (is_last && !is_first) sum_.bind(static_cast<int>(kImagesMax));
    shader.set("u_sum", static_cast<int>(kImagesMax));
    if (!is_first && !is_last) {  // adds to earlier passes
      gl_.Enable(GL_BLEND);
      gl_.BlendFunc(GL_ONE, GL_ONE);
    }
    draw(is_last ? target.id() : sum_.id(), 0, shape.width, shape.height);
    gl_.Disable(GL_BLEND);
    done += count;
  } while (done < images.size());
  const ShaderProgram& mip = program({"MULTUM_MIP"});
  mip.use();
  mip.set("u_finer", 0);
  for (int l = 1; l < shape.level_count; ++l) {
    // Restricts sampling to the level that is read. Otherwise the draw would read the texture that it writes.
    gl_.TextureParameteri(target.id(), GL_TEXTURE_BASE_LEVEL, l - 1);
    gl_.TextureParameteri(target.id(), GL_TEXTURE_MAX_LEVEL, l - 1);
    target.bind(0);
    draw(target.id(), l, std::max(1, shape.width >> l), std::max(1, shape.height >> l));
  }
  gl_.TextureParameteri(target.id(), GL_TEXTURE_BASE_LEVEL, 0);
  gl_.TextureParameteri(target.id(), GL_TEXTURE_MAX_LEVEL, shape.level_count - 1);
  gl_.NamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, 0, 0);
  check_gl(gl_, "adding up images");
}

}  // namespace multum::gl
