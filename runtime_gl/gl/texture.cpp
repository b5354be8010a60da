// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/texture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"

namespace multum::gl {
namespace {

// These names are from GL 4.6, and have the same values as in ARB_ and EXT_texture_filter_anisotropic. An older
// GL/glcorearb.h may lack them.
constexpr GLenum kTextureMaxAnisotropy = 0x84FE;
constexpr GLenum kMaxTextureMaxAnisotropy = 0x84FF;

GLenum internal_format(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgba16Snorm: return GL_RGBA16_SNORM;
    case TexelFormat::kRgba16f: return GL_RGBA16F;
    case TexelFormat::kRgba32f: return GL_RGBA32F;
    case TexelFormat::kRgba8: return GL_RGBA8;
    case TexelFormat::kBc5: return GL_COMPRESSED_RG_RGTC2;
  }
  return GL_RGBA32F;
}

GLint wrap_value(WrapMode mode) {
  switch (mode) {
    case WrapMode::kBlack: return GL_CLAMP_TO_BORDER;
    case WrapMode::kClamp: return GL_CLAMP_TO_EDGE;
    case WrapMode::kPeriodic: return GL_REPEAT;
    case WrapMode::kMirror: return GL_MIRRORED_REPEAT;
  }
  return GL_REPEAT;
}

int level_size(int size, int level) { return std::max(1, size >> level); }

std::int16_t float_to_snorm16(float value) {
  return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * 32767.0f));
}

void set_anisotropy(const GlFunctions& gl, GLuint texture, float anisotropy) {
  if (anisotropy <= 1.0f) return;
  if (!has_gl_extension(gl, "GL_ARB_texture_filter_anisotropic") &&
      !has_gl_extension(gl, "GL_EXT_texture_filter_anisotropic"))
    throw Error(ErrorCode::kEnvironment,
                "cannot filter anisotropically: the GL driver has no GL_EXT_texture_filter_anisotropic");
  GLfloat anisotropy_max = 1.0f;
  gl.GetFloatv(kMaxTextureMaxAnisotropy, &anisotropy_max);
  gl.TextureParameterf(texture, kTextureMaxAnisotropy, std::min(anisotropy, anisotropy_max));
}

void check_size(const GlFunctions& gl, const std::string& name, const TextureShape& shape) {
  MULTUM_CHECK(shape.width > 0 && shape.height > 0 && shape.level_count > 0);
  GLint size_max = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &size_max);
  if (shape.width > size_max || shape.height > size_max)
    throw Error(ErrorCode::kEnvironment, name + " is " + std::to_string(shape.width) + " x " +
                                             std::to_string(shape.height) + " texels; this GL supports at most " +
                                             std::to_string(size_max) + " in each direction");
  GLint layers_max = 0;
  gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers_max);
  if (shape.layer_count > layers_max)
    throw Error(ErrorCode::kEnvironment, name + " has " + std::to_string(shape.layer_count) +
                                             " layers; this GL supports at most " + std::to_string(layers_max));
}

}  // namespace

const char* texel_format_name(TexelFormat format) {
  switch (format) {
    case TexelFormat::kRgba16Snorm: return "RGBA16_SNORM";
    case TexelFormat::kRgba16f: return "RGBA16F";
    case TexelFormat::kRgba32f: return "RGBA32F";
    case TexelFormat::kRgba8: return "RGBA8";
    case TexelFormat::kBc5: return "BC5";
  }
  return "?";
}

Texture::Texture(const GlFunctions& gl, std::string name, const TextureShape& shape)
    : gl_(&gl), name_(std::move(name)), shape_(shape) {
  gl.CreateTextures(shape.layer_count > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, 1, &id_);
}

Texture::Texture(const GlFunctions& gl, std::string name, const TextureShape& shape, const SamplerSettings& sampler)
    : Texture(gl, std::move(name), shape) {
  check_size(gl, name_, shape);
  if (shape.layer_count > 0)
    gl.TextureStorage3D(id_, shape.level_count, internal_format(shape.format), shape.width, shape.height,
                        shape.layer_count);
  else gl.TextureStorage2D(id_, shape.level_count, internal_format(shape.format), shape.width, shape.height);
  gl.TextureParameteri(id_, GL_TEXTURE_WRAP_S, wrap_value(sampler.wrap_s));
  gl.TextureParameteri(id_, GL_TEXTURE_WRAP_T, wrap_value(sampler.wrap_t));
  gl.TextureParameteri(id_, GL_TEXTURE_MIN_FILTER, sampler.filtered ? GL_LINEAR_MIPMAP_LINEAR : GL_NEAREST);
  gl.TextureParameteri(id_, GL_TEXTURE_MAG_FILTER, sampler.filtered ? GL_LINEAR : GL_NEAREST);
  // Beyond a "black" border there is no material, so the lobe has amplitude 0.
  const GLfloat border[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  gl.TextureParameterfv(id_, GL_TEXTURE_BORDER_COLOR, border);
  if (sampler.filtered) set_anisotropy(gl, id_, sampler.anisotropy);
  check_gl(gl, "allocating " + name_);
}

Texture::~Texture() {
  if (id_ != 0) gl_->DeleteTextures(1, &id_);
}

Texture::Texture(Texture&& other) noexcept
    : gl_(other.gl_), name_(std::move(other.name_)), shape_(other.shape_), id_(std::exchange(other.id_, 0)) {}

void Texture::upload_level(int level, const float* rgba) {
  MULTUM_CHECK(shape_.layer_count == 0);
  upload(level, 0, rgba);
}

void Texture::upload_layer(int level, int layer, const float* rgba) {
  MULTUM_CHECK(layer >= 0 && layer < shape_.layer_count);
  upload(level, layer, rgba);
}

void Texture::upload(int level, int layer, const float* rgba) {
  MULTUM_CHECK(level >= 0 && level < shape_.level_count);
  const int width = level_size(shape_.width, level);
  const int height = level_size(shape_.height, level);
  const std::size_t count = 4u * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const auto send = [&](GLenum type, const void* data) {
    if (shape_.layer_count > 0) gl_->TextureSubImage3D(id_, level, 0, 0, layer, width, height, 1, GL_RGBA, type, data);
    else gl_->TextureSubImage2D(id_, level, 0, 0, width, height, GL_RGBA, type, data);
  };
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (shape_.format == TexelFormat::kRgba32f) {
    send(GL_FLOAT, rgba);
  } else if (shape_.format == TexelFormat::kRgba16f) {
    std::vector<std::uint16_t> halfs(count);
    std::transform(rgba, rgba + count, halfs.begin(), float_to_half);
    send(GL_HALF_FLOAT, halfs.data());
  } else {
    std::vector<std::int16_t> integers(count);
    std::transform(rgba, rgba + count, integers.begin(), float_to_snorm16);
    send(GL_SHORT, integers.data());
  }
  check_gl(*gl_, "uploading level " + std::to_string(level) + " of " + name_);
}

void Texture::upload_rows(int level, int first_row, int row_count, const std::uint16_t* halves) {
  MULTUM_CHECK(shape_.layer_count == 0 && shape_.format == TexelFormat::kRgba16f && level < shape_.level_count);
  MULTUM_CHECK(first_row >= 0 && first_row + row_count <= level_size(shape_.height, level));
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_->TextureSubImage2D(id_, level, 0, first_row, level_size(shape_.width, level), row_count, GL_RGBA, GL_HALF_FLOAT,
                         halves);
  check_gl(*gl_, "uploading rows of " + name_);
}

void Texture::upload_bytes(int level, const std::vector<std::uint8_t>& bytes) {
  MULTUM_CHECK(shape_.layer_count > 0 && level >= 0 && level < shape_.level_count);
  const int width = level_size(shape_.width, level), height = level_size(shape_.height, level);
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (shape_.format == TexelFormat::kBc5) {
    gl_->CompressedTextureSubImage3D(id_, level, 0, 0, 0, width, height, shape_.layer_count, GL_COMPRESSED_RG_RGTC2,
                                     static_cast<GLsizei>(bytes.size()), bytes.data());
  } else {
    MULTUM_CHECK(shape_.format == TexelFormat::kRgba8 || shape_.format == TexelFormat::kRgba16f);
    gl_->TextureSubImage3D(id_, level, 0, 0, 0, width, height, shape_.layer_count, GL_RGBA,
                           shape_.format == TexelFormat::kRgba8 ? GL_UNSIGNED_BYTE : GL_HALF_FLOAT, bytes.data());
  }
  check_gl(*gl_, "uploading level " + std::to_string(level) + " of " + name_);
}

std::vector<float> Texture::read_level(int level) const {
  MULTUM_CHECK(shape_.layer_count == 0);
  const std::size_t width = static_cast<std::size_t>(level_size(shape_.width, level));
  const std::size_t height = static_cast<std::size_t>(level_size(shape_.height, level));
  std::vector<float> values(4 * width * height);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  if (shape_.format == TexelFormat::kRgba16Snorm) {
    // Reads integers, because NVIDIA's driver (580) converts them to floats by OpenGL 4.1's mapping, (2 c + 1) / 65535.
    std::vector<std::int16_t> integers(values.size());
    gl_->GetTextureImage(id_, level, GL_RGBA, GL_SHORT, static_cast<GLsizei>(integers.size() * sizeof(std::int16_t)),
                         integers.data());
    std::transform(integers.begin(), integers.end(), values.begin(),
                   [](std::int16_t c) { return std::max(static_cast<float>(c) / 32767.0f, -1.0f); });
  } else {
    gl_->GetTextureImage(id_, level, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(values.size() * sizeof(float)),
                         values.data());
  }
  check_gl(*gl_, "reading level " + std::to_string(level) + " of " + name_);
  return values;
}

}  // namespace multum::gl
