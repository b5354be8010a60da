// SPDX-License-Identifier: Apache-2.0
// Writes pictures to disk, atomically.
#pragma once

#include <string>

#include "runtime_gl/gl/framebuffer.h"

namespace multum {

/// Writes by the name's extension. .png: values times `exposure`, clamped, sRGB, 8 bits. .exr: linear values, 32-bit
/// floats, exposure not applied. Throws Error(kUsage) for other names, Error(kEnvironment) if the disk refuses.
void write_picture(const std::string& path, const gl::FloatImage& image, float exposure);

/// Throws Error(kUsage) unless write_picture() supports the name's extension.
void check_picture_path(const std::string& path);

}  // namespace multum
