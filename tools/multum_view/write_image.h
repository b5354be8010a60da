// SPDX-License-Identifier: Apache-2.0
// Pictures to disk, atomically.
#pragma once

#include <string>

#include "runtime_gl/gl/framebuffer.h"

namespace multum {

/// By the name's extension: .png = `exposure` times the values, clamped, sRGB, 8 bits; .exr = the linear values, 32-bit
/// floats, exposure not applied. Throws Error(kUsage) for other names, Error(kEnvironment) when the disk refuses.
void write_picture(const std::string& path, const gl::FloatImage& image, float exposure);

/// Throws Error(kUsage) unless write_picture() can write such a name.
void check_picture_path(const std::string& path);

}  // namespace multum
