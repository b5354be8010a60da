// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/normal_material.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/base/error.h"

namespace multum::gl {
namespace {

// Slopes grow without bound towards the horizon; 20 (87 degrees) keeps one such texel from drowning its neighbours.
constexpr float kSlopeMax = 20.0f;

struct Plane {
  int width;
  int height;
  std::vector<glm::vec4> texels;
};

/// One output texel covers [x W/w, (x+1) W/w) of W input texels: its inputs and their shares, summing to 1.
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

/// The next coarser level, box filter. (Of the level above, not of the finest texels: for sizes that are no powers of
/// two a baseline's weights are those of any mip generator.)
Plane halve(const Plane& fine) {
  Plane coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
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

Texture upload(const GlFunctions& gl, const char* name, Plane plane, int level_count, const SamplerSettings& sampler) {
  Texture texture(gl, name, {plane.width, plane.height, level_count, TexelFormat::kRgba32f}, sampler);
  for (int l = 0; l < level_count; ++l) {
    if (l > 0) plane = halve(plane);
    texture.upload_level(l, &plane.texels[0].x);
  }
  return texture;
}

glm::vec2 slope(const glm::vec3& n) {
  const float z = std::max(n.z, 1e-3f);
  glm::vec2 b(n.x / z, n.y / z);
  const float size = glm::length(b);
  return size > kSlopeMax ? b * (kSlopeMax / size) : b;
}

}  // namespace

NormalImage finest_normals(const MovmfMipmap& mipmap) {
  MULTUM_CHECK(!mipmap.levels.empty());
  const MovmfLevel& level = mipmap.levels.front();
  NormalImage image{level.width, level.height, {}, {}, mipmap.wrap_s, mipmap.wrap_t};
  const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  for (std::size_t i = 0; i < texels; ++i) {
    glm::vec3 normal(0.0f);
    glm::vec3 colour(0.0f);
    for (const auto& lobe : level.lobes) normal += glm::vec3(lobe[i]);
    for (const auto& lobe_colour : level.colours) colour += lobe_colour[i];
    const float size = glm::length(normal);
    image.normals.push_back(size > 0.0f ? normal / size : glm::vec3(0.0f, 0.0f, 1.0f));
    if (mipmap.has_colours()) image.albedo.push_back(colour);
  }
  return image;
}

NormalMaterial::NormalMaterial(const GlFunctions& gl, const NormalImage& image, Sampling sampling, float anisotropy) {
  MULTUM_CHECK(image.normals.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  MULTUM_CHECK(image.albedo.empty() || image.albedo.size() == image.normals.size());
  const bool mipmapped = sampling == Sampling::kMipmapped;
  const int level_count = mipmapped ? mip_level_count(image.width, image.height) : 1;
  const SamplerSettings sampler{image.wrap_s, image.wrap_t, mipmapped, anisotropy};
  Plane normals{image.width, image.height, {}};
  Plane slopes{image.width, image.height, {}};
  for (const glm::vec3& n : image.normals) {
    const glm::vec2 b = slope(n);
    normals.texels.emplace_back(n, b.x * b.y);
    if (mipmapped) slopes.texels.emplace_back(b.x, b.y, b.x * b.x, b.y * b.y);
  }
  normals_.emplace(upload(gl, "the normals", std::move(normals), level_count, sampler));
  if (mipmapped) slopes_.emplace(upload(gl, "the slopes", std::move(slopes), level_count, sampler));
  if (image.albedo.empty()) return;
  Plane albedo{image.width, image.height, {}};
  for (const glm::vec3& colour : image.albedo) albedo.texels.emplace_back(colour, 1.0f);
  albedo_.emplace(upload(gl, "the albedo", std::move(albedo), level_count, sampler));
}

void NormalMaterial::bind() const {
  normals_->bind(0);
  if (slopes_.has_value()) slopes_->bind(1);
  if (albedo_.has_value()) albedo_->bind(2);
}

}  // namespace multum::gl
