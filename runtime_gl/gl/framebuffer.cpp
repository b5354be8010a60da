// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/framebuffer.h"

#include <algorithm>

#include "host/base/error.h"

namespace multum::gl {
namespace {

void check_size(const GlFunctions& gl, int width, int height) {
  GLint size_max = 0;
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &size_max);
  if (width < 1 || height < 1 || width > size_max || height > size_max)
    throw Error(ErrorCode::kEnvironment, "a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                                             " was asked for; this GL renders 1 x 1 up to " + std::to_string(size_max) +
                                             " x " + std::to_string(size_max));
}

}  // namespace

Framebuffer::Framebuffer(const GlFunctions& gl) : gl_(&gl) {
  gl.CreateTextures(GL_TEXTURE_2D, 1, &colour_);
  gl.CreateRenderbuffers(1, &depth_);
  gl.CreateFramebuffers(1, &framebuffer_);
}

Framebuffer::Framebuffer(const GlFunctions& gl, int width, int height) : Framebuffer(gl) {
  width_ = width;
  height_ = height;
  check_size(gl, width, height);
  gl.TextureStorage2D(colour_, 1, GL_RGBA32F, width, height);
  gl.TextureParameteri(colour_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureParameteri(colour_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.NamedRenderbufferStorage(depth_, GL_DEPTH_COMPONENT32F, width, height);
  gl.NamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, colour_, 0);
  gl.NamedFramebufferRenderbuffer(framebuffer_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  check_gl(gl, "allocating the picture");
  const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer_, GL_DRAW_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw Error(ErrorCode::kEnvironment,
                "the GL driver refuses an RGBA32F picture: framebuffer status " + std::to_string(status));
}

Framebuffer::~Framebuffer() {
  gl_->DeleteFramebuffers(1, &framebuffer_);
  gl_->DeleteRenderbuffers(1, &depth_);
  gl_->DeleteTextures(1, &colour_);
}

void Framebuffer::bind() const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->Viewport(0, 0, width_, height_);
}

void Framebuffer::clear_colour(float value) const {
  const GLfloat values[4] = {value, value, value, value};
  gl_->ClearNamedFramebufferfv(framebuffer_, GL_COLOR, 0, values);
}

void Framebuffer::clear_depth() const {
  const GLfloat one = 1.0f;
  gl_->ClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &one);
}

FloatImage Framebuffer::read() const {
  const std::size_t row = 4u * static_cast<std::size_t>(width_);
  FloatImage image{width_, height_, std::vector<float>(row * static_cast<std::size_t>(height_))};
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_->ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, image.rgba.data());
  check_gl(*gl_, "reading the picture back");
  // GL's first row is the bottom one.
  for (std::size_t top = 0, bottom = image.rgba.size() - row; top < bottom; top += row, bottom -= row)
    std::swap_ranges(image.rgba.begin() + static_cast<std::ptrdiff_t>(top),
                     image.rgba.begin() + static_cast<std::ptrdiff_t>(top + row),
                     image.rgba.begin() + static_cast<std::ptrdiff_t>(bottom));
  return image;
}

}  // namespace multum::gl
