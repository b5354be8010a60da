// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/context/headless_context.h"

#include <algorithm>
#include <iterator>

#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "runtime_gl/context/egl_context.h"
#include "runtime_gl/context/osmesa_context.h"

namespace multum::gl {
namespace {

void APIENTRY on_debug_message(GLenum /*source*/, GLenum type, GLuint /*id*/, GLenum /*severity*/, GLsizei /*length*/,
                               const GLchar* message, const void* /*user*/) {
  // check_gl() throws an Error for each GL error. This log line adds the driver's message.
  if (type == GL_DEBUG_TYPE_ERROR) log_warning("GL", message);
}

}  // namespace

void HeadlessContext::load(GetProcAddress get_proc_address, DebugOutput debug) {
  functions_ = load_gl_functions(get_proc_address);
  description_ = std::string(context_backend_name(backend())) + ": " + gl_string(functions_, GL_RENDERER) + ", " +
                 gl_string(functions_, GL_VERSION);
  if (debug == DebugOutput::kOff) return;
  // Debug output is core since OpenGL 4.3. The output is synchronous, so that a message appears before the exception of
  // the step that caused it.
  functions_.Enable(GL_DEBUG_OUTPUT);
  functions_.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  functions_.DebugMessageCallback(on_debug_message, nullptr);
}

bool HeadlessContext::is_software() const {
  constexpr const char* kRenderers[] = {"llvmpipe", "softpipe", "swrast", "SwiftShader", "Software Rasterizer"};
  return std::any_of(std::begin(kRenderers), std::end(kRenderers),
                     [&](const char* name) { return description_.find(name) != std::string::npos; });
}

std::unique_ptr<HeadlessContext> make_headless_context(ContextBackend backend, DebugOutput debug) {
  std::string reasons;
  if (backend != ContextBackend::kOsmesa) {
    try {
      return make_egl_context(debug);
    } catch (const Error& error) {
      if (backend == ContextBackend::kEgl) throw;
      reasons = error.what();
    }
  }
  try {
    return make_osmesa_context(debug);
  } catch (const Error& error) {
    if (reasons.empty()) throw;
    throw Error(ErrorCode::kEnvironment, "no OpenGL 4.5 context: " + reasons + "; " + error.what());
  }
}

}  // namespace multum::gl
