// SPDX-License-Identifier: Apache-2.0
// Chooses the colour axes of a chunk: the eigenvectors of the colours' covariance, texels weighed by what is seen of
// them, so that nearly all of a texture lies in one plane (Karhunen-Loeve transform). A rotation, so that errors of the
// planes add up to errors of red, green and blue.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace multum {

struct ColourAxes {
  std::array<float, 3> mean{};
  /// The rotation whose rows are the axes, the longest first: w, x, y, z in 1/32767.
  std::array<std::int16_t, 4> quaternion{32767, 0, 0, 0};
};

/// `textures`: [texel][3] each; `weights`: of each texel, at least 0. Where no texel weighs anything, red, green, blue.
ColourAxes colour_axes(const std::vector<std::vector<float>>& textures, const std::vector<float>& weights);

}  // namespace multum
