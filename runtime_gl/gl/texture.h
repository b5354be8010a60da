// SPDX-License-Identifier: Apache-2.0
// Defines a two-dimensional texture, or an array of such textures. The levels of a texture are uploaded explicitly,
// because mip levels are data. The driver never makes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/foundation/base/wrap_mode.h"
#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

/// All formats have four channels except BC5, which has two. Use kRgba8 and kBc5 only for data that is already in a GPU
/// format (upload_bytes()), because llvmpipe filters these formats with 8 bits.
enum class TexelFormat { kRgba16Snorm, kRgba16f, kRgba32f, kRgba8, kBc5 };

const char* texel_format_name(TexelFormat format);

struct TextureShape {
  int width = 1;
  int height = 1;
  int level_count = 1;
  TexelFormat format = TexelFormat::kRgba32f;
  int layer_count = 0;  // layers of an array (sampler2DArray); 0 if it is not an array
};

struct SamplerSettings {
  WrapMode wrap_s = WrapMode::kPeriodic;
  WrapMode wrap_t = WrapMode::kPeriodic;
  bool filtered = true;     // if false, reads the nearest texel of level 0
  float anisotropy = 1.0f;  // 1 to 16; above 1 needs GL_ARB_ or GL_EXT_texture_filter_anisotropic
};

class Texture {
 public:
  /// Allocates every level. `name` appears in messages. Throws Error(kEnvironment) if the size exceeds the device's
  /// limit or memory runs out.
  Texture(const GlFunctions& gl, std::string name, const TextureShape& shape, const SamplerSettings& sampler);
  ~Texture();
  Texture(Texture&& other) noexcept;
  Texture& operator=(Texture&&) = delete;
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  /// `rgba` has 4 floats per texel and starts with row 0, which is at texture coordinate t = 0. Values are rounded to
  /// the nearest value of the format. These are multiples of 1/32767 clamped to [-1, 1], or 16-bit floats with ties to
  /// even. 32-bit floats are not rounded.
  void upload_level(int level, const float* rgba);
  /// Uploads whole rows of a level unchanged, from four 16-bit floats per texel. The format must be kRgba16f, and the
  /// texture must not be an array.
  void upload_rows(int level, int first_row, int row_count, const std::uint16_t* halves);
  /// Uploads one whole layer of an array.
  void upload_layer(int level, int layer, const float* rgba);
  /// Uploads all layers of a level of an array unchanged, one after another. The format must be kRgba16f, kRgba8 or
  /// kBc5.
  void upload_bytes(int level, const std::vector<std::uint8_t>& bytes);
  /// Returns a level as floats. The texture must not be an array.
  std::vector<float> read_level(int level) const;

  void bind(int unit) const { gl_->BindTextureUnit(static_cast<GLuint>(unit), id_); }
  GLuint id() const { return id_; }
  const TextureShape& shape() const { return shape_; }

 private:
  void upload(int level, int layer, const float* rgba);
  // Creates the name before anything can throw.
  Texture(const GlFunctions& gl, std::string name, const TextureShape& shape);

  const GlFunctions* gl_;
  std::string name_;
  TextureShape shape_;
  GLuint id_ = 0;
};

}  // namespace multum::gl
