// SPDX-License-Identifier: Apache-2.0
// Writes pictures to disk, atomically.
#pragma once

#include <string>

#include "runtime_gl/gl/framebuffer.h"

namespace multum {

/// Writes a PNG or EXR file, by the extension of the name. .png: values times `exposure`, clamped, sRGB, 8 bits. .exr:
/// linear 32-bit floats without `exposure`. Throws Error(kUsage) for other names, Error(kEnvironment) if writing fails.
void write_picture(const std::string& path, const gl::FloatImage& image, float exposure);

/// Throws Error(kUsage) unless write_picture() supports the name's extension.
void check_picture_path(const std::string& path);

}  // namespace multum
