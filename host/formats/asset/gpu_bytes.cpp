// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/gpu_bytes.h"

namespace multum {
namespace {

// Returns the bytes of the stored levels of all four-channel textures.
std::uint64_t texture_bytes(const BakedHeader& header, const TexelCounts& counts) {
  std::uint64_t texels = 0;
  for (int l = header.first_level; l < header.level_count(); ++l)
    texels += static_cast<std::uint64_t>(mip_level_size(header.width, l)) *
              static_cast<std::uint64_t>(mip_level_size(header.height, l));
  const int textures =
      texture_count(header.representation, counts, (header.has_colours ? 1 : 0) + (header.weight_count > 0 ? 1 : 0));
  const unsigned value_bytes = header.encoding == StorageEncoding::kFloat ? 4 : 2;
  return texels * static_cast<unsigned>(textures) * 4 * value_bytes;
}

constexpr std::uint64_t kBc5BlockBytes = 16, kBc4BlockBytes = 8;

// Returns the number of blocks of 4 x 4 texels in the levels from 0 to level_end - 1.
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
  return texture_bytes(full_header(mipmap), {.lobes = mipmap.lobe_count()});
}

std::uint64_t moment_gpu_bytes(const BakedHeader& header) { return texture_bytes(header, {}); }

std::uint64_t sh_gpu_bytes(const ShMipmap& mipmap) { return texture_bytes(mipmap.header, {.sh_order = mipmap.order}); }

std::uint64_t baked_gpu_bytes(const std::string& path) {
  return representation_info(read_baked_header(path).representation).gpu_bytes(path);
}

std::uint64_t finest_normals_gpu_bytes(int width, int height, int first_level) {
  return block_count(width, height, first_level) * kBc5BlockBytes;
}

std::uint64_t default_gpu_bytes(int width, int height) {
  return block_count(width, height, mip_level_count(width, height)) * (kBc5BlockBytes + kBc4BlockBytes);
}

}  // namespace multum
