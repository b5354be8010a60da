// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/gpu_bytes.h"

namespace multum {
namespace {

// Stored levels of so many textures of four channels; weights are one beside each lobe or all moments.
std::uint64_t texture_bytes(const BakedHeader& header, unsigned texture_count) {
  std::uint64_t texels = 0;
  for (int l = header.first_level; l < header.level_count(); ++l)
    texels += static_cast<std::uint64_t>(mip_level_size(header.width, l)) *
              static_cast<std::uint64_t>(mip_level_size(header.height, l));
  const unsigned value_bytes = header.encoding == StorageEncoding::kFloat ? 4 : 2;
  return texels * texture_count * 4 * value_bytes;
}

constexpr std::uint64_t kBc5BlockBytes = 16, kBc4BlockBytes = 8;

// Of 4 x 4 texels, of levels [0, level_end).
std::uint64_t block_count(int width, int height, int level_end) {
  std::uint64_t blocks = 0;
  for (int l = 0; l < level_end; ++l) {
    const auto across = static_cast<std::uint64_t>((mip_level_size(width, l) + 3) / 4);
    blocks += across * static_cast<std::uint64_t>((mip_level_size(height, l) + 3) / 4);
  }
  return blocks;
}

}  // namespace

std::uint64_t movmf_gpu_bytes(const MovmfMipmap& mipmap) {
  const unsigned textures_a_lobe = 1u + (mipmap.has_colours() ? 1u : 0u) + (mipmap.header.weight_count > 0 ? 1u : 0u);
  return texture_bytes(full_header(mipmap), static_cast<unsigned>(mipmap.lobe_count()) * textures_a_lobe);
}

std::uint64_t moment_gpu_bytes(const BakedHeader& header) {
  return texture_bytes(header, 2u + (header.has_colours ? 1u : 0u) + (header.weight_count > 0 ? 1u : 0u));
}

std::uint64_t sh_gpu_bytes(const ShMipmap& mipmap) {
  const BakedHeader& header = mipmap.header;
  return texture_bytes(header, static_cast<unsigned>(sh_part_count(mipmap.order)) + (header.has_colours ? 1u : 0u) +
                                   (header.weight_count > 0 ? 1u : 0u));
}

std::uint64_t baked_gpu_bytes(const std::string& path) {
  const BakedHeader header = read_baked_header(path);
  switch (header.representation) {
    case Representation::kMovmf:
    case Representation::kGmm: return movmf_gpu_bytes(read_movmf_header(path));
    case Representation::kMoments: return moment_gpu_bytes(header);
    case Representation::kSh: return sh_gpu_bytes(read_sh_header(path));
  }
  return 0;
}

std::uint64_t finest_normals_gpu_bytes(int width, int height, int first_level) {
  return block_count(width, height, first_level) * kBc5BlockBytes;
}

std::uint64_t default_gpu_bytes(int width, int height) {
  return block_count(width, height, mip_level_count(width, height)) * (kBc5BlockBytes + kBc4BlockBytes);
}

}  // namespace multum
