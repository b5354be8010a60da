// SPDX-License-Identifier: Apache-2.0
// Counts the bytes of a baked file's textures on a GPU, and of the textures that renderers usually keep for the same
// map.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Bytes of the stored levels of all lobes. A texel has 4 channels with 2 bytes each (RGBA16_SNORM, RGBA16F) or 4 bytes
/// each (RGBA32F). Colours need the same number of bytes, because their fourth channel is padding (RGBA16F or RGBA32F).
/// Needs only sizes, no texels.
std::uint64_t movmf_gpu_bytes(const MovmfMipmap& mipmap);

/// Bytes of the stored levels of a file of moments: two textures of 4 channels (docs/reference/file_format.md,
/// "Moments"), and one for colours.
std::uint64_t moment_gpu_bytes(const BakedHeader& header);

/// Bytes of the stored levels of a file of spherical harmonics: one 4-channel layer per four coefficients, and one
/// texture for colours. Needs only sizes, no texels.
std::uint64_t sh_gpu_bytes(const ShMipmap& mipmap);

/// Bytes of a baked file of any representation, with its colours and weights. Throws as read_baked_header() does.
std::uint64_t baked_gpu_bytes(const std::string& path);

/// Bytes of the levels finer than `first_level` of a width x height map as a BC5 normal. Renderers need this normal
/// map next to a file that does not store these levels.
std::uint64_t finest_normals_gpu_bytes(int width, int height, int first_level);

/// Bytes of all levels of a width x height map as a BC5 normal (16 bytes per block of 4 x 4 texels) and a BC4 roughness
/// (8 bytes per block). Only whole blocks exist, so even a level of 1 x 1 needs one block.
std::uint64_t default_gpu_bytes(int width, int height);

}  // namespace multum
