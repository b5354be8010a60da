// SPDX-License-Identifier: Apache-2.0
// Blue noise for renderers that draw at random what they would add up: errors of neighbouring pixels differ, so that a
// denoiser, or the eye, takes them out. Made when the project is built (void_and_cluster); common/blue_noise.glsl says
// how it is read.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

constexpr int kBlueNoiseSide = 64;

/// RGBA8, [row][column][4]: four masks that have nothing to do with each other, each of their 256 values 16 times.
std::span<const std::uint8_t> blue_noise();

}  // namespace multum
