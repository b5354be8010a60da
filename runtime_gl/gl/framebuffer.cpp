// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/framebuffer.h"

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum::gl {
namespace {

void check_size(const GlFunctions& gl, int width, int height) {
  GLint size_max = 0;
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &size_max);
  if (width < 1 || height < 1 || width > size_max || height > size_max)
    throw Error(ErrorCode::kEnvironment, "cannot draw a picture of " + std::to_string(width) + " x " +
                                             std::to_string(height) + " pixels: this GL supports 1 x 1 to " +
                                             std::to_string(size_max) + " x " + std::to_string(size_max));
}

}  // namespace

Framebuffer::Framebuffer(const GlFunctions& gl, int colour_count)
    : gl_(&gl), colours_(static_cast<std::size_t>(colour_count)) {
  gl.CreateTextures(GL_TEXTURE_2D, colour_count, colours_.data());
  gl.CreateRenderbuffers(1, &depth_);
  gl.CreateFramebuffers(1, &framebuffer_);
}

Framebuffer::Framebuffer(const GlFunctions& gl, int width, int height, int colour_count)
    : Framebuffer(gl, colour_count) {
  width_ = width;
  height_ = height;
  check_size(gl, width, height);
  std::vector<GLenum> buffers;
  for (const GLuint colour : colours_) {
    gl.TextureStorage2D(colour, 1, GL_RGBA32F, width, height);
    gl.TextureParameteri(colour, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TextureParameteri(colour, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    const auto buffer = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + buffers.size());
    gl.NamedFramebufferTexture(framebuffer_, buffer, colour, 0);
    buffers.push_back(buffer);
  }
  gl.NamedFramebufferDrawBuffers(framebuffer_, colour_count, buffers.data());
  gl.NamedRenderbufferStorage(depth_, GL_DEPTH_COMPONENT32F, width, height);
  gl.NamedFramebufferRenderbuffer(framebuffer_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  check_gl(gl, "allocating the picture");
  const GLenum status = gl.CheckNamedFramebufferStatus(framebuffer_, GL_DRAW_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw Error(ErrorCode::kEnvironment,
                "the GL driver rejects an RGBA32F picture: framebuffer status " + std::to_string(status));
}

Framebuffer::~Framebuffer() {
  gl_->DeleteFramebuffers(1, &framebuffer_);
  gl_->DeleteRenderbuffers(1, &depth_);
  gl_->DeleteTextures(static_cast<GLsizei>(colours_.size()), colours_.data());
}

void Framebuffer::bind_rows(int bottom_row, int picture_height) const {
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->Viewport(0, -bottom_row, width_, picture_height);
}

void Framebuffer::clear_colour(float value) const {
  const GLfloat values[4] = {value, value, value, value};
  for (std::size_t i = 0; i < colours_.size(); ++i)
    gl_->ClearNamedFramebufferfv(framebuffer_, GL_COLOR, static_cast<GLint>(i), values);
}

void Framebuffer::clear_depth() const {
  const GLfloat one = 1.0f;
  gl_->ClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &one);
}

FloatImage Framebuffer::read(int colour, const PixelRectangle& part) const {
  const std::size_t row = 4u * static_cast<std::size_t>(part.width);
  FloatImage image{part.width, part.height, std::vector<float>(row * static_cast<std::size_t>(part.height))};
  gl_->BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_->NamedFramebufferReadBuffer(framebuffer_, GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(colour));
  gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
  // The first row in OpenGL is the bottom row.
  gl_->ReadPixels(part.x, height_ - part.y - part.height, part.width, part.height, GL_RGBA, GL_FLOAT,
                  image.rgba.data());
  check_gl(*gl_, "reading the picture back");
  for (std::size_t top = 0, bottom = image.rgba.size() - row; top < bottom; top += row, bottom -= row)
    std::swap_ranges(image.rgba.begin() + static_cast<std::ptrdiff_t>(top),
                     image.rgba.begin() + static_cast<std::ptrdiff_t>(top + row),
                     image.rgba.begin() + static_cast<std::ptrdiff_t>(bottom));
  return image;
}

}  // namespace multum::gl
