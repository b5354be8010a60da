// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/mip_texture.h"

#include <algorithm>

namespace multum::gl {
namespace {

/// The input texels of an output texel, and their shares, which sum to 1. The output texel covers [x W/w, (x+1) W/w) of
/// W input texels.
struct Coverage {
  int first;
  std::vector<float> shares;
};

std::vector<Coverage> coverage(int from, int to) {
  std::vector<Coverage> all(static_cast<std::size_t>(to));
  const double step = static_cast<double>(from) / to;
  for (int x = 0; x < to; ++x) {
    const double begin = x * step;
    const double end = std::min<double>(begin + step, from);
    Coverage& one = all[static_cast<std::size_t>(x)];
    one.first = static_cast<int>(begin);
    for (int i = one.first; i < from && i < end; ++i)
      one.shares.push_back(static_cast<float>((std::min<double>(i + 1, end) - std::max<double>(i, begin)) / step));
  }
  return all;
}

/// Returns the next coarser level.
TexelPlane halve(const TexelPlane& fine) {
  TexelPlane coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
  const std::vector<Coverage> columns = coverage(fine.width, coarse.width);
  const std::vector<Coverage> rows = coverage(fine.height, coarse.height);
  coarse.texels.reserve(columns.size() * rows.size());
  for (const Coverage& row : rows)
    for (const Coverage& column : columns) {
      glm::vec4 sum(0.0f);
      for (std::size_t j = 0; j < row.shares.size(); ++j)
        for (std::size_t i = 0; i < column.shares.size(); ++i) {
          const std::size_t y = static_cast<std::size_t>(row.first) + j;
          const std::size_t x = static_cast<std::size_t>(column.first) + i;
          sum += row.shares[j] * column.shares[i] * fine.texels[y * static_cast<std::size_t>(fine.width) + x];
        }
      coarse.texels.push_back(sum);
    }
  return coarse;
}

}  // namespace

Texture upload_mips(const GlFunctions& gl, const char* name, TexelPlane plane, int level_count,
                    const SamplerSettings& sampler) {
  Texture texture(gl, name, {plane.width, plane.height, level_count, TexelFormat::kRgba32f}, sampler);
  for (int l = 0; l < level_count; ++l) {
    if (l > 0) plane = halve(plane);
    texture.upload_level(l, &plane.texels[0].x);
  }
  return texture;
}

}  // namespace multum::gl
