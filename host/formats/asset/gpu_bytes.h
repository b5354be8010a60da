// SPDX-License-Identifier: Apache-2.0
// Counts the bytes that a baked file takes as textures on a GPU, and those that renderers usually keep for the same
// map.
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Stored levels of all lobes, 4 channels a texel of 2 bytes each (RGBA16_SNORM, RGBA16F) or 4 (RGBA32F), and as much
/// again for colours, whose fourth channel is padding (RGBA16F or RGBA32F). Needs sizes alone, no texels.
std::uint64_t movmf_gpu_bytes(const MovmfMipmap& mipmap);

/// Stored levels of a file of moments: two textures of 4 channels (docs/reference/file_format.md, "Moments"), and one
/// for colours.
std::uint64_t moment_gpu_bytes(const BakedHeader& header);

/// Stored levels of a file of spherical harmonics: a layer of 4 channels every four coefficients, and one texture for
/// colours. Needs sizes alone, no texels.
std::uint64_t sh_gpu_bytes(const ShMipmap& mipmap);

/// Bytes of a baked file of any representation, its colours and weights included. Throws as read_baked_header() does.
std::uint64_t baked_gpu_bytes(const std::string& path);

/// Levels finer than `first_level` of a width x height map as a BC5 normal: what renderers have beside a file that
/// leaves these levels to the normal map.
std::uint64_t finest_normals_gpu_bytes(int width, int height, int first_level);

/// Bytes of all levels of a width x height map as a BC5 normal, 16 bytes a block of 4 x 4 texels, and a BC4 roughness,
/// 8 bytes. Blocks are whole: a level of 1 x 1 takes one as well.
std::uint64_t default_gpu_bytes(int width, int height);

}  // namespace multum
