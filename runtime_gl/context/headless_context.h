// SPDX-License-Identifier: Apache-2.0
// Defines an OpenGL 4.5 core context that needs no window, display server or GPU. It is one interface with two
// back-ends.
//   osmesa  libOSMesa.so.8: Mesa's software renderer, which needs only the library.
//   egl     libEGL.so.1: each GPU of the device platform, then the surfaceless platform, then software devices; no
//           config, no surface. Only this back-end reaches a GPU. It does not try eglGetDisplay(EGL_DEFAULT_DISPLAY),
//           which needs a display server.
// Both libraries are opened at run time with RTLD_LOCAL, so a program links no GL library and can use both in one
// process.
#pragma once

#include <memory>
#include <string>

#include "host/foundation/parameters/parameter_choices.h"
#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

using multum::ContextBackend;

inline const char* context_backend_name(ContextBackend backend) { return choice_name(kContextBackends, backend); }

/// The debug output of the driver. With kOn, the problems of each call are logged immediately as warnings. The driver
/// then waits for each call, so timed code must use kOff.
enum class DebugOutput { kOff, kOn };

#ifdef MULTUM_DEBUG_CHECKS
inline constexpr DebugOutput kUsualDebugOutput = DebugOutput::kOn;
#else
inline constexpr DebugOutput kUsualDebugOutput = DebugOutput::kOff;
#endif

class HeadlessContext {
 public:
  virtual ~HeadlessContext() = default;
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

  /// Makes this context current in the calling thread. A new context is already current.
  virtual void make_current() = 0;
  virtual ContextBackend backend() const = 0;

  const GlFunctions& functions() const { return functions_; }
  /// Returns a description such as "osmesa: llvmpipe (...), 4.5 (Core Profile) Mesa 22.3.6".
  const std::string& description() const { return description_; }
  /// Returns whether the CPU draws, which the renderer's name shows (llvmpipe, softpipe, SwiftShader and others).
  bool is_software() const;

 protected:
  HeadlessContext() = default;
  /// Fills the function table, checks the version and turns on KHR_debug (core since OpenGL 4.3) if requested. A
  /// back-end must call this when its context is current.
  void load(GetProcAddress get_proc_address, DebugOutput debug);

  GlFunctions functions_;
  std::string description_;
};

/// kAuto tries EGL first, because only EGL reaches a GPU, and then OSMesa. Throws Error(kEnvironment), whose message
/// names what each tried back-end lacks.
std::unique_ptr<HeadlessContext> make_headless_context(ContextBackend backend, DebugOutput debug = kUsualDebugOutput);

}  // namespace multum::gl
