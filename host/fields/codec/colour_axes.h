// SPDX-License-Identifier: Apache-2.0
// Chooses the colour axes of a chunk. These are the eigenvectors of the colours' covariance, with texels weighted by
// their visibility. Nearly all of a texture's variance is then in the first colour plane (Karhunen-Loeve transform).
// The axes form a rotation, so that squared errors of the planes add up to squared errors of red, green and blue.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace multum {

struct ColourAxes {
  std::array<float, 3> mean{};
  /// The colour axes are the rows of a rotation, and the first row is the axis of the largest variance. The rotation is
  /// stored as a quaternion (w, x, y, z in units of 1/32767).
  std::array<std::int16_t, 4> quaternion{32767, 0, 0, 0};
};

/// Each of the `textures` is [texel][3]. `weights` has one weight per texel, at least 0. If all weights are 0, the axes
/// are red, green and blue.
ColourAxes colour_axes(const std::vector<std::vector<float>>& textures, const std::vector<float>& weights);

}  // namespace multum
