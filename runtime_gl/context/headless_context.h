// SPDX-License-Identifier: Apache-2.0
// An OpenGL 4.5 core context without a window, a display server or a GPU: one interface, two back-ends behind it.
//   osmesa  libOSMesa.so.8: Mesa's software renderer, needs nothing but the library.
//   egl     libEGL.so.1: each GPU of the device platform, then the surfaceless platform, then software devices; no
//           config, no surface. This is the way to a GPU. eglGetDisplay(EGL_DEFAULT_DISPLAY) is not tried: it wants a
//           display server.
// Both libraries are opened at run time with RTLD_LOCAL, so a program links no GL and both can live in one process.
#pragma once

#include <memory>
#include <string>

#include "host/foundation/parameters/parameter_choices.h"
#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

using multum::ContextBackend;

inline const char* context_backend_name(ContextBackend backend) { return choice_name(kContextBackends, backend); }

/// Whether the driver says at once, as a warning, what it thinks of each call. It then waits for each, so that nothing
/// that is timed may have it.
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

  /// Makes this context the calling thread's current one. A new context is current already.
  virtual void make_current() = 0;
  virtual ContextBackend backend() const = 0;

  const GlFunctions& functions() const { return functions_; }
  /// "osmesa: llvmpipe (...), 4.5 (Core Profile) Mesa 22.3.6"
  const std::string& description() const { return description_; }
  /// Whether processors draw, as the renderer's name says: llvmpipe, softpipe, SwiftShader, ...
  bool is_software() const;

 protected:
  HeadlessContext() = default;
  /// Called by a back-end once its context is current: fills the function table, checks the version, turns KHR_debug on
  /// where it is wanted (in the core since 4.3).
  void load(GetProcAddress get_proc_address, DebugOutput debug);

  GlFunctions functions_;
  std::string description_;
};

/// kAuto: EGL first, since only it reaches a GPU, then OSMesa. Throws Error(kEnvironment) that says what each back-end
/// that was tried lacked.
std::unique_ptr<HeadlessContext> make_headless_context(ContextBackend backend, DebugOutput debug = kUsualDebugOutput);

}  // namespace multum::gl
