// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/report/level_textures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "host/delivery/export/accuracy/cell_reference.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// Returns the index of a texel on a side of `size` texels that repeats.
int wrapped(int texel, int size) {
  const int rest = texel % size;
  return rest < 0 ? rest + size : rest;
}

constexpr int kMeanChannels = 4;

// Adds a row of the finest level to the rows of a coarser level that cover it.
void add_row(TextureLevel& level, int row, int width, int height, const std::vector<float>& values) {
  const auto begin = static_cast<int>(std::int64_t{row} * level.height / height);
  for (int y = begin; y < level.height; ++y) {
    const double down = covered_length(row, y, height, level.height);
    if (down <= 0.0) break;
    for (int column = 0; column < width; ++column)
      for (auto x = static_cast<int>(std::int64_t{column} * level.width / width); x < level.width; ++x) {
        const double along = covered_length(column, x, width, level.width);
        if (along <= 0.0) break;
        const double share = down * along * level.width * level.height / (static_cast<double>(width) * height);
        float* const to = &level.texels[(size_of(y) * size_of(level.width) + size_of(x)) * kMeanChannels];
        for (int c = 0; c < kMeanChannels; ++c)
          to[c] += static_cast<float>(share * static_cast<double>(values[size_of(column * kMeanChannels + c)]));
      }
  }
}

}  // namespace

void LevelTexture::add_bilinear(const TextureLevel& level, double u, double v, double share, double* values) const {
  const double x = u * level.width - 0.5, y = v * level.height - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double weight = share * (i == 0 ? x0 + 1 - x : x - x0) * (j == 0 ? y0 + 1 - y : y - y0);
      const std::size_t at =
          (size_of(wrapped(y0 + j, level.height)) * size_of(level.width) + size_of(wrapped(x0 + i, level.width))) *
          size_of(channel_count_);
      for (int c = 0; c < channel_count_; ++c) values[c] += weight * static_cast<double>(level.texels[at + size_of(c)]);
    }
}

void LevelTexture::sample(double level, double u, double v, double* values) const {
  std::fill_n(values, channel_count_, 0.0);
  const double place = std::clamp(level - first_level_, 0.0, static_cast<double>(levels_.size() - 1));
  const auto below = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(below);
  add_bilinear(levels_[below], u, v, 1.0 - share, values);
  if (share > 0.0) add_bilinear(levels_[below + 1], u, v, share, values);
}

LevelTexture averaged_levels(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                             int first_level) {
  const int width = normals.width(), height = normals.height();
  LevelTexture texture(kMeanChannels, first_level);
  for (int level = first_level; level < mip_level_count(width, height); ++level) {
    TextureLevel made{mip_level_size(width, level), mip_level_size(height, level), {}};
    made.texels.resize(size_of(made.width) * size_of(made.height) * kMeanChannels);
    texture.levels().push_back(std::move(made));
  }
  std::vector<float> x(size_of(width)), y(x), z(x), base(x), values(x.size() * kMeanChannels);
  for (int row = 0; row < height; ++row) {
    normals.read_rows(row, 1, {x.data(), y.data(), z.data()});
    if (material != nullptr) material->read_rows(0, row, 1, base.data());
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double a2 =
          std::max(kAlphaMin * kAlphaMin, material != nullptr ? static_cast<double>(base[i]) : alpha_squared);
      float* const to = &values[i * kMeanChannels];
      to[0] = x[i], to[1] = y[i], to[2] = z[i], to[3] = static_cast<float>(std::pow(a2, 0.25));
    }
    for (TextureLevel& level : texture.levels()) add_row(level, row, width, height, values);
  }
  return texture;
}

}  // namespace multum
