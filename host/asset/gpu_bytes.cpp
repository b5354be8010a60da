// SPDX-License-Identifier: Apache-2.0
#include "host/asset/gpu_bytes.h"

namespace multum {

std::uint64_t movmf_gpu_bytes(const MovmfMipmap& mipmap) {
  std::uint64_t texels = 0;
  for (std::size_t l = static_cast<std::size_t>(mipmap.first_level); l < mipmap.levels.size(); ++l)
    texels += static_cast<std::uint64_t>(mipmap.levels[l].width) * static_cast<std::uint64_t>(mipmap.levels[l].height);
  const unsigned value_bytes = mipmap.encoding == StorageEncoding::kFloat ? 4 : 2;
  const unsigned texture_count = static_cast<unsigned>(mipmap.lobe_count()) * (mipmap.has_colours() ? 2 : 1);
  return texels * texture_count * 4 * value_bytes;
}

std::uint64_t usual_gpu_bytes(int width, int height) {
  constexpr std::uint64_t kBlockBytes = 16 + 8;
  std::uint64_t blocks = 0;
  for (int l = 0; l < mip_level_count(width, height); ++l) {
    const auto across = static_cast<std::uint64_t>((mip_level_size(width, l) + 3) / 4);
    blocks += across * static_cast<std::uint64_t>((mip_level_size(height, l) + 3) / 4);
  }
  return blocks * kBlockBytes;
}

}  // namespace multum
