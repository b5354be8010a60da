// SPDX-License-Identifier: Apache-2.0
// Writes pictures to disk, atomically.
#pragma once

#include <string>

#include "runtime_gl/gl/framebuffer.h"

namespace multum {

/// Writes a PNG or EXR file, as the extension of the name says. PNG files hold values times `exposure`, clamped, as
/// 8-bit sRGB. EXR files hold linear 32-bit floats without `exposure`. Throws Error(kUsage) for other names, and
/// Error(kEnvironment) if writing fails.
void write_picture(const std::string& path, const gl::FloatImage& image, float exposure);

/// Throws Error(kUsage) unless write_picture() supports the name's extension.
void check_picture_path(const std::string& path);

}  // namespace multum
