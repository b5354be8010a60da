// SPDX-License-Identifier: Apache-2.0
// The EGL back-end: EGL_MESA_platform_surfaceless, then every device of EGL_EXT_device_enumeration; needs
// EGL_KHR_no_config_context and EGL_KHR_surfaceless_context of the display.
#pragma once

#include <memory>

#include "runtime_gl/context/headless_context.h"

namespace multum::gl {

/// Throws Error(kEnvironment) that says what every display that was tried lacked.
std::unique_ptr<HeadlessContext> make_egl_context();

}  // namespace multum::gl
