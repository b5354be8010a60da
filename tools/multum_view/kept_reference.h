// SPDX-License-Identifier: Apache-2.0
// Keeps a reference picture for later runs, which compare other bakes of the same map with it (--keep-reference): to
// draw it takes longer than all else that a comparison does. A file of this program's own, in the machine's byte order.
//
//   "MTREF001"  width, height, samples: int32   noise, frame_time_ms: double   width * height * RGBA: float
#pragma once

#include <string>

#include "runtime_gl/render/renderer.h"

namespace multum {

/// Is a file there? Not whether it can be used.
bool has_kept_reference(const std::string& path);

/// Throws Error(kInput) for a file that write_kept_reference() did not write, or not of this size.
gl::Picture read_kept_reference(const std::string& path, int width, int height);

/// Throws Error(kEnvironment).
void write_kept_reference(const std::string& path, const gl::Picture& reference);

}  // namespace multum
