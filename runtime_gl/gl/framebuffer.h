// SPDX-License-Identifier: Apache-2.0
// A linear RGBA32F colour buffer with a 32-bit depth buffer, read back exactly.
#pragma once

#include <vector>

#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

/// Linear RGBA, alpha = coverage; rows from top to bottom.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;
};

class Framebuffer {
 public:
  /// Throws Error(kEnvironment): too large for the device, out of memory.
  Framebuffer(const GlFunctions& gl, int width, int height);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Draws go here from now on, over the whole of it.
  void bind() const;
  /// Every channel of every pixel.
  void clear_colour(float value = 0.0f) const;
  void clear_depth() const;
  /// The colour buffer as a texture; its filter is nearest.
  void bind_colour(int unit) const { gl_->BindTextureUnit(static_cast<GLuint>(unit), colour_); }
  FloatImage read() const;

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  explicit Framebuffer(const GlFunctions& gl);  // owns the names before anything can throw

  const GlFunctions* gl_;
  int width_ = 0;
  int height_ = 0;
  GLuint framebuffer_ = 0;
  GLuint colour_ = 0;
  GLuint depth_ = 0;
};

}  // namespace multum::gl
