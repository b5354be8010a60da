// SPDX-License-Identifier: Apache-2.0
// Makes the scene on which tests measure filter matrices. Waves in perspective run towards the horizon and are partly
// behind a board. They have every degree of minification and slant.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "host/foundation/base/split_mix.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/probe/placed_mesh.h"

namespace multum::gl {

inline MeshData wave_mesh(float repeats) {
  constexpr int kCells = 32;
  MeshData data;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const float u = static_cast<float>(i) / kCells, v = static_cast<float>(j) / kCells;
      const float x = 3.0f * u - 1.5f, z = 1.4f - 9.0f * v;
      MeshVertex vertex{};
      vertex.position = {x, 0.25f * std::sin(3.0f * x) * std::cos(2.0f * z), z};
      vertex.uv = glm::vec2(u, v) * repeats;
      data.vertices.push_back(vertex);
    }
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i, b = a + kCells + 1;
      for (const std::uint32_t k : {a, a + 1, b, a + 1, b + 1, b}) data.indices.push_back(k);
    }
  return data;
}

inline MeshData board_mesh() {
  MeshData data;
  for (const glm::vec3& p : {glm::vec3(-0.6f, -0.3f, 0.2f), glm::vec3(-0.1f, -0.3f, 0.2f), glm::vec3(-0.1f, 0.3f, 0.2f),
                             glm::vec3(-0.6f, 0.3f, 0.2f)}) {
    MeshVertex vertex{};
    vertex.position = p;
    data.vertices.push_back(vertex);
  }
  data.indices = {0, 1, 2, 0, 2, 3};
  return data;
}

inline glm::mat4 probe_camera(int width, int height) {
  const glm::mat4 view = glm::lookAt(glm::vec3(0.35f, 0.45f, 1.9f), glm::vec3(0.0f, -0.05f, 0.2f), glm::vec3(0, 1, 0));
  return glm::perspective(0.9f, static_cast<float>(width) / static_cast<float>(height), 0.05f, 50.0f) * view;
}

/// Returns random RGBA values in 0..1 for every texel of every level, in the order of MipLayout.
inline std::vector<float> random_texels(int texel_count, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<float> texels(4u * static_cast<std::size_t>(texel_count));
  for (float& value : texels) value = static_cast<float>(random.uniform());
  return texels;
}

}  // namespace multum::gl
