// SPDX-License-Identifier: Apache-2.0
// Defines the OSMesa back-end, which uses OSMesaCreateContextAttribs and a small dummy buffer. Drawing goes to
// framebuffer objects.
#pragma once

#include <memory>

#include "runtime_gl/context/headless_context.h"

namespace multum::gl {

/// Throws Error(kEnvironment) if the library is missing or cannot create the context.
std::unique_ptr<HeadlessContext> make_osmesa_context(DebugOutput debug);

}  // namespace multum::gl
