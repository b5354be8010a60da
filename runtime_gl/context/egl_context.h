// SPDX-License-Identifier: Apache-2.0
// Defines the EGL back-end, which tries EGL_MESA_platform_surfaceless and every device of EGL_EXT_device_enumeration.
// The display must have EGL_KHR_no_config_context and EGL_KHR_surfaceless_context.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime_gl/context/headless_context.h"

namespace multum::gl {

/// Creates a context on the first display that has OpenGL 4.5 with all functions. Throws Error(kEnvironment), whose
/// message names what each tried display lacks.
std::unique_ptr<HeadlessContext> make_egl_context(DebugOutput debug);

/// A display that EGL offers. Displays are listed in the order in which make_egl_context() tries them.
struct EglOffer {
  std::string display;      // such as "device 0" or "surfaceless"
  bool is_software;         // as reported by the device's driver
  std::string description;  // description of the display's context; empty if it has none
  std::string reason;       // reason why it is unusable
};

/// Lists the displays. Opens and closes a context on each of them. Throws Error(kEnvironment) if libEGL.so.1 is
/// missing.
std::vector<EglOffer> list_egl_offers();

}  // namespace multum::gl
