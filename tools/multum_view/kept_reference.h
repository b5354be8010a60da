// SPDX-License-Identifier: Apache-2.0
// Keeps a reference picture for later runs, which compare other bakes of the same map with it (--keep-reference).
// Drawing the reference takes longer than the rest of a comparison. The file has the byte order of the machine, and it
// is read only by this program.
//
//   "MTREF001"  width, height, samples: int32   noise, frame_time_ms: double   width * height * RGBA: float
#pragma once

#include <string>

#include "runtime_gl/render/renderer.h"

namespace multum {

/// Returns whether a file exists at `path`. The file may still be unusable.
bool has_kept_reference(const std::string& path);

/// Throws Error(kInput) if the file was not written by write_kept_reference() or has another size.
gl::Picture read_kept_reference(const std::string& path, int width, int height);

/// Throws Error(kEnvironment) if the file cannot be written.
void write_kept_reference(const std::string& path, const gl::Picture& reference);

}  // namespace multum
