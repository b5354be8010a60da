// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/test_maps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/foundation/base/split_mix.h"

namespace multum::gl {
namespace {

std::size_t texel_count(int size) { return static_cast<std::size_t>(size) * static_cast<std::size_t>(size); }

MovmfLevel make_level(int size, std::size_t lobe_count, bool coloured) {
  MovmfLevel level;
  level.width = level.height = size;
  level.lobes.assign(lobe_count, std::vector<glm::vec4>(texel_count(size)));
  if (coloured) level.colours.assign(lobe_count, std::vector<glm::vec3>(texel_count(size)));
  return level;
}

}  // namespace

MeshData make_quad(float size) {
  const float half = 0.5f * size;
  MeshData mesh;
  const glm::vec2 corners[] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
  for (const glm::vec2& corner : corners)
    mesh.vertices.push_back(
        {{corner.x * size - half, corner.y * size, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f, 1.0f}, corner});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

TestMap make_flat_map(int size) {
  TestMap map;
  map.image = {size, size, std::vector<glm::vec3>(texel_count(size), {0.0f, 0.0f, 1.0f}), {}};
  for (int s = size; s > 0; s /= 2) {
    map.mipmap.levels.push_back(make_level(s, 1, false));
    for (glm::vec4& lobe : map.mipmap.levels.back().lobes[0]) lobe = {0.0f, 0.0f, 1.0f, 1.0f};
  }
  return map;
}

TestMap make_wave_map(int size, WrapMode wrap) {
  NormalImage image{size, size, {}, {}, wrap, wrap};
  const double step = 2.0 * std::numbers::pi / size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const glm::dvec3 n(0.7 * std::sin(step * (x + 0.5)), 0.5 * std::sin(step * (y + 0.5)), 1.0);
      image.normals.emplace_back(glm::normalize(n));
    }
  return make_one_lobe_map(std::move(image));
}

TestMap make_noise_map(int size, float slope, WrapMode wrap) {
  NormalImage image{size, size, {}, {}, wrap, wrap};
  SplitMix64 random(17);
  const auto uniform = [&] { return slope * static_cast<float>(2.0 * random.uniform() - 1.0); };
  for (std::size_t i = 0; i < texel_count(size); ++i) {
    const float x = uniform(), y = uniform();
    image.normals.push_back(glm::normalize(glm::vec3(x, y, 1.0f)));
  }
  return make_one_lobe_map(std::move(image));
}

TestMap make_one_lobe_map(NormalImage image) {
  TestMap map;
  map.image = std::move(image);
  map.mipmap.header.wrap_s = map.image.wrap_s;
  map.mipmap.header.wrap_t = map.image.wrap_t;
  map.mipmap.header.encoding = StorageEncoding::kFloat;
  std::vector<glm::vec4> texels;
  for (const glm::vec3& n : map.image.normals) texels.emplace_back(n, 1.0f);
  for (int s = map.image.width;; s /= 2) {
    map.mipmap.levels.push_back(make_level(s, 1, false));
    map.mipmap.levels.back().lobes[0] = texels;
    if (s == 1) return map;
    const std::size_t columns = static_cast<std::size_t>(s);
    std::vector<glm::vec4> coarse;
    for (std::size_t y = 0; y < columns; y += 2)
      for (std::size_t x = 0; x < columns; x += 2) {
        const glm::vec4* const upper = &texels[y * columns + x];
        coarse.push_back(0.25f * (upper[0] + upper[1] + upper[columns] + upper[columns + 1]));
      }
    texels = std::move(coarse);
  }
}

TestMap make_two_tilt_map(int size, double angle_degrees, StorageEncoding encoding, bool coloured) {
  const double angle = angle_degrees * std::numbers::pi / 180.0;
  const glm::vec3 tilts[2] = {{std::sin(angle), 0.0, std::cos(angle)}, {-std::sin(angle), 0.0, std::cos(angle)}};
  const glm::vec3 colours[2] = {{0.9f, 0.1f, 0.1f}, {0.1f, 0.1f, 0.9f}};
  TestMap map;
  map.mipmap.header.encoding = encoding;
  map.image.width = map.image.height = size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      map.image.normals.push_back(tilts[(x + y) % 2]);
      if (coloured) map.image.albedo.push_back(colours[(x + y) % 2]);
    }
  for (int s = size; s > 0; s /= 2) {
    map.mipmap.levels.push_back(make_level(s, 2, coloured));
    MovmfLevel& level = map.mipmap.levels.back();
    for (std::size_t i = 0; i < texel_count(s); ++i)
      for (std::size_t j = 0; j < 2; ++j) {
        const std::size_t columns = static_cast<std::size_t>(s);
        const float amplitude = s < size ? 0.5f : (i % columns + i / columns) % 2 == j ? 1.0f : 0.0f;
        level.lobes[j][i] = amplitude * glm::vec4(tilts[j], 1.0f);
        if (coloured) level.colours[j][i] = amplitude * colours[j];
      }
  }
  return map;
}

MomentMipmap make_moments(const NormalImage& image, StorageEncoding encoding) {
  MomentMipmap mipmap;
  mipmap.header.representation = Representation::kMoments;
  mipmap.header.encoding = encoding;
  mipmap.header.wrap_s = image.wrap_s;
  mipmap.header.wrap_t = image.wrap_t;
  mipmap.header.width = image.width;
  mipmap.header.height = image.height;
  mipmap.header.has_colours = !image.albedo.empty();
  mipmap.levels = empty_moment_levels(image.width, image.height);
  for (MomentLevel& level : mipmap.levels) {
    const int across = image.width / level.width, down = image.height / level.height;
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x) {
        glm::dvec3 normal(0.0), colour(0.0);
        double s = 0.0, t = 0.0, ss = 0.0, tt = 0.0, st = 0.0;
        const double share = 1.0 / (across * down);
        for (int i = 0; i < across * down; ++i) {
          const auto texel = static_cast<std::size_t>((y * down + i / across) * image.width + x * across + i % across);
          const glm::dvec3 n(image.normals[texel]);
          const double z = std::max(n.z, static_cast<double>(kSlopeZMin)), u = -n.x / z, v = -n.y / z;
          normal += share * n;
          if (mipmap.header.has_colours) colour += share * glm::dvec3(image.albedo[texel]);
          s += share * u;
          t += share * v;
          ss += share * u * u;
          tt += share * v * v;
          st += share * u * v;
        }
        level.slopes.push_back({kNoHeight, static_cast<float>(s), static_cast<float>(t), static_cast<float>(ss),
                                static_cast<float>(tt), static_cast<float>(st)});
        level.normals.emplace_back(normal);
        if (mipmap.header.has_colours) level.colours.emplace_back(colour);
      }
    quantize_moments(level, encoding, 1);
  }
  return mipmap;
}

MovmfMipmap as_gaussians(MovmfMipmap mipmap) {
  mipmap.header.representation = Representation::kGmm;
  for (MovmfLevel& level : mipmap.levels)
    for (auto& lobes : level.lobes)
      for (glm::vec4& lobe : lobes)
        if (lobe.w > 0.0f && mipmap.header.has_roughness)
          lobe = lobe.w * glm::vec4(rough_point(glm::vec3(lobe) / lobe.w), 1.0f);
        else lobe.z = lobe.w > 0.0f ? (lobe.x * lobe.x + lobe.y * lobe.y) / lobe.w : 0.0f;
  quantize_movmf(mipmap, 1);
  return mipmap;
}

RenderScene distant_scene() {
  RenderScene scene;
  scene.camera.eye = {0.0f, -8.0f, 12.0f};
  scene.camera.target = {0.0f, 8.0f, 0.0f};
  scene.uv_scale = 60.0f;
  return scene;
}

void look_from_above(RenderScene& scene, double texels, int size, int height) {
  scene.camera.eye = {0.0f, 30.0f, 60.0f};
  scene.camera.target = {0.0f, 30.0f, 0.0f};
  scene.camera.up = {0.0f, 1.0f, 0.0f};
  // The plane shows the map once every 60 units.
  const double angle = static_cast<double>(scene.camera.fov_y_degrees) * std::numbers::pi / 180.0;
  scene.uv_scale = static_cast<float>(texels * 60.0 / size * height / (2.0 * 60.0 * std::tan(0.5 * angle)));
}

}  // namespace multum::gl
