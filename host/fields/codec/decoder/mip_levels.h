// SPDX-License-Identifier: Apache-2.0
// Makes the mip levels of a texture from its finest level, which is the only level that a chunk stores. Each level is
// the box-filtered mean of the next finer one, in linear radiance. Level l has max(1, W >> l) by max(1, H >> l) texels.
// If a side is odd, each coarse texel covers n / floor(n / 2) fine texels, weighted by the covered part.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace multum {

/// Returns the number of texels of all levels, down to 1 x 1.
std::size_t mip_texel_count(std::size_t width, std::size_t height);

/// Returns all levels, [texel][3], the finest first. `finest` is [height][width][3].
std::vector<float> mip_levels(std::size_t width, std::size_t height, std::span<const float> finest);

/// Applies the adjoint of mip_levels(). This adds values of all levels, [texel][channels], to the finest level with the
/// same weights.
std::vector<float> handed_down(std::size_t width, std::size_t height, std::size_t channels, std::vector<float> levels);

}  // namespace multum
