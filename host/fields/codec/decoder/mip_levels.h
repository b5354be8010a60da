// SPDX-License-Identifier: Apache-2.0
// Makes the mip levels of a texture from its finest, which is all that a chunk stores: each level the box-filtered mean
// of the next finer one, in linear radiance. Level l has max(1, W >> l) by max(1, H >> l) texels; where a side is odd,
// each coarse texel covers n / floor(n / 2) fine ones and weighs them by what it covers.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace multum {

/// Texels of all levels, down to 1 x 1.
std::size_t mip_texel_count(std::size_t width, std::size_t height);

/// All levels, the finest first, [texel][3]; `finest`: [height][width][3].
std::vector<float> mip_levels(std::size_t width, std::size_t height, std::span<const float> finest);

/// The adjoint: values of all levels, [texel][channels], handed down to the finest by the weights that it has in them.
std::vector<float> handed_down(std::size_t width, std::size_t height, std::size_t channels, std::vector<float> levels);

}  // namespace multum
