// SPDX-License-Identifier: Apache-2.0
// Writes pictures to disk, atomically.
#pragma once

#include <string>

#include "runtime_gl/gl/framebuffer.h"

namespace multum {

/// Writes a PNG or EXR file, depending on the extension of the name. PNG files hold values that are multiplied by
/// `exposure`, clamped and converted to 8-bit sRGB. EXR files hold linear 32-bit floats, to which `exposure` is not
/// applied. Throws Error(kUsage) for other extensions, and Error(kEnvironment) if writing fails.
void write_picture(const std::string& path, const gl::FloatImage& image, float exposure);

/// Throws Error(kUsage) unless write_picture() supports the name's extension.
void check_picture_path(const std::string& path);

}  // namespace multum
