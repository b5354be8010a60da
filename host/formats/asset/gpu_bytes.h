// SPDX-License-Identifier: Apache-2.0
// Counts the bytes that the textures of a baked file need on a GPU. Also counts the bytes of the textures that
// renderers usually keep for the same map.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Returns the bytes of the stored levels of all lobes. A texel has 4 channels with 2 bytes each (RGBA16_SNORM,
/// RGBA16F) or 4 bytes each (RGBA32F). Colours need the same number of bytes, because their fourth channel is padding
/// (RGBA16F or RGBA32F). The function needs only sizes, no texels.
std::uint64_t movmf_gpu_bytes(const MovmfMipmap& mipmap);

/// Returns the bytes of the stored levels of a file of moments. Such a file has two textures of 4 channels
/// (docs/reference/file_format.md, "Moments"), and one texture for colours.
std::uint64_t moment_gpu_bytes(const BakedHeader& header);

/// Returns the bytes of the stored levels of a file of spherical harmonics. Such a file has one 4-channel layer per
/// four coefficients, and one texture for colours. The function needs only sizes, no texels.
std::uint64_t sh_gpu_bytes(const ShMipmap& mipmap);

/// Returns the bytes of a baked file of any representation, with its colours and weights. Throws like
/// read_baked_header().
std::uint64_t baked_gpu_bytes(const std::string& path);

/// Returns the bytes of the levels finer than `first_level` of a width x height normal map in BC5. Renderers need these
/// levels if a baked file does not store them.
std::uint64_t finest_normals_gpu_bytes(int width, int height, int first_level);

/// Returns the bytes of all levels of a width x height normal map in BC5 (16 bytes per block of 4 x 4 texels) and a
/// roughness map in BC4 (8 bytes per block). Only whole blocks exist, so even a level of 1 x 1 needs one block.
std::uint64_t default_gpu_bytes(int width, int height);

}  // namespace multum
