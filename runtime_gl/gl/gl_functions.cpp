// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/gl_functions.h"

#include <cstring>

#include "host/foundation/base/error.h"

namespace multum::gl {
namespace {

template <typename Function>
Function find_function(GetProcAddress get_proc_address, const char* name) {
  const GlFunction function = get_proc_address(name);
  if (function == nullptr) throw Error(ErrorCode::kEnvironment, std::string("the GL driver has no function ") + name);
  return reinterpret_cast<Function>(function);
}

}  // namespace

GlFunctions load_gl_functions(GetProcAddress get_proc_address) {
  GlFunctions gl;
  gl.GetIntegerv = find_function<PFNGLGETINTEGERVPROC>(get_proc_address, "glGetIntegerv");
  GLint major = 0;
  GLint minor = 0;
  gl.GetIntegerv(GL_MAJOR_VERSION, &major);
  gl.GetIntegerv(GL_MINOR_VERSION, &minor);
  // Version 4.5 has direct state access. There are no binding points to save and restore, so objects cannot affect one
  // another.
  if (major * 10 + minor < 45)
    throw Error(ErrorCode::kEnvironment, "the GL context has version " + std::to_string(major) + "." +
                                             std::to_string(minor) + ", expected 4.5 or later");
#define MULTUM_GL_FIND(type, name) gl.name = find_function<type>(get_proc_address, "gl" #name);
  MULTUM_GL_FUNCTIONS(MULTUM_GL_FIND)
#undef MULTUM_GL_FIND
  return gl;
}

bool has_gl_extension(const GlFunctions& gl, const char* extension) {
  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const GLubyte* name = gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (name != nullptr && std::strcmp(reinterpret_cast<const char*>(name), extension) == 0) return true;
  }
  return false;
}

std::string gl_string(const GlFunctions& gl, GLenum name) {
  const GLubyte* text = gl.GetString(name);
  return text != nullptr ? reinterpret_cast<const char*>(text) : "?";
}

const char* gl_error_name(GLenum error) {
  switch (error) {
    case GL_NO_ERROR: return "GL_NO_ERROR";
    case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
    default: return "unknown GL error";
  }
}

void check_gl(const GlFunctions& gl, const std::string& step) {
  const GLenum first = gl.GetError();
  if (first == GL_NO_ERROR) return;
  // A context can hold several error flags. A lost context returns errors forever, so the number of iterations is
  // limited.
  for (int i = 0; i < 16 && gl.GetError() != GL_NO_ERROR; ++i) {
  }
  throw Error(ErrorCode::kEnvironment, step + ": " + gl_error_name(first));
}

}  // namespace multum::gl
