// SPDX-License-Identifier: Apache-2.0
// The EGL back-end: EGL_MESA_platform_surfaceless, then every device of EGL_EXT_device_enumeration; needs
// EGL_KHR_no_config_context and EGL_KHR_surfaceless_context of the display.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime_gl/context/headless_context.h"

namespace multum::gl {

/// A context of the first display that gives one of OpenGL 4.5 with all functions. Throws Error(kEnvironment) that says
/// what every display that was tried lacked.
std::unique_ptr<HeadlessContext> make_egl_context(DebugOutput debug);

/// A display that EGL offers, in the order in which make_egl_context() tries them.
struct EglOffer {
  std::string display;      // "device 0", "surfaceless"
  bool is_software;         // as the driver says of a device
  std::string description;  // of the context that it gives; empty: it gives none
  std::string reason;       // why not
};

/// Opens and closes a context on each. Throws Error(kEnvironment) without libEGL.so.1.
std::vector<EglOffer> list_egl_offers();

}  // namespace multum::gl
