// SPDX-License-Identifier: Apache-2.0
// Provides blue noise for renderers that sample at random. The errors of neighbouring pixels then differ, so that a
// denoiser, or the eye, removes them. The noise is made when the project is built (void_and_cluster).
// common/blue_noise.glsl describes how to read it.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

constexpr int kBlueNoiseSide = 64;

/// RGBA8 texels [row][column][4] that hold four independent masks. Each of the 256 values occurs 16 times in a mask.
std::span<const std::uint8_t> blue_noise();

}  // namespace multum
