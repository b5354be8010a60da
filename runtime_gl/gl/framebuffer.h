// SPDX-License-Identifier: Apache-2.0
// Defines linear RGBA32F colour buffers with a 32-bit depth buffer. Pixels are read back exactly.
#pragma once

#include <vector>

#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

/// A linear RGBA picture whose alpha is the coverage. Rows run from top to bottom.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> rgba;
};

/// A part of a picture. Row 0 is at the top.
struct PixelRectangle {
  int x = 0, y = 0;
  int width = 0, height = 0;
};

class Framebuffer {
 public:
  /// Fragment output i goes to colour buffer i. Throws Error(kEnvironment) if the size exceeds the device's limit or
  /// memory runs out.
  Framebuffer(const GlFunctions& gl, int width, int height, int colour_count = 1);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Directs later draws to the whole framebuffer.
  void bind() const { bind_rows(0, height_); }
  /// Directs later draws to a part of a taller picture. The framebuffer holds the picture's rows from `bottom_row` on,
  /// counted from below. If `bottom_row` is even, groups of 2 x 2 fragments stay together.
  void bind_rows(int bottom_row, int picture_height) const;
  /// Sets every channel of every pixel in all colour buffers.
  void clear_colour(float value = 0.0f) const;
  void clear_depth() const;
  /// Binds the first colour buffer as a texture with nearest filtering.
  void bind_colour(int unit) const { gl_->BindTextureUnit(static_cast<GLuint>(unit), colours_.front()); }
  FloatImage read() const { return read(0, {0, 0, width_, height_}); }
  FloatImage read(int colour, const PixelRectangle& part) const;

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  Framebuffer(const GlFunctions& gl, int colour_count);  // creates the names before anything can throw

  const GlFunctions* gl_;
  int width_ = 0;
  int height_ = 0;
  GLuint framebuffer_ = 0;
  std::vector<GLuint> colours_;
  GLuint depth_ = 0;
};

}  // namespace multum::gl
