// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/environment_background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/render/environment_shading.h"

namespace multum::gl {
namespace {

constexpr int kSamplesASide = 2;  // samples along a pixel's side; maps are rarely finer than pictures

// Interpolates between texel centres. The map repeats horizontally.
glm::vec3 radiance(const EnvironmentMap& map, glm::dvec2 st) {
  const double x = st.x * map.width - 0.5, y = std::clamp(st.y * map.height - 0.5, 0.0, map.height - 1.0);
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(y);
  const auto texel = [&](int column, int row) {
    const int wrapped = (column % map.width + map.width) % map.width;
    const int clamped = std::min(row, map.height - 1);
    return map.texels[static_cast<std::size_t>(clamped) * static_cast<std::size_t>(map.width) +
                      static_cast<std::size_t>(wrapped)];
  };
  const auto across = static_cast<float>(x - left), down = static_cast<float>(y - top);
  return glm::mix(glm::mix(texel(left, top), texel(left + 1, top), across),
                  glm::mix(texel(left, top + 1), texel(left + 1, top + 1), across), down);
}

}  // namespace

FloatImage environment_background(const RenderScene& scene, int width, int height) {
  MULTUM_CHECK(scene.environment != nullptr);
  const EnvironmentMap& map = scene.environment->map;
  const std::array<glm::vec3, 3> axes = environment_axes(scene);
  const glm::mat4 inverse = glm::inverse(view_projection(scene.camera, width, height, glm::vec2(0.0f)));
  // Directions are linear over the picture before they are normalised.
  const auto at_far = [&](float x, float y) {
    const glm::vec4 far = inverse * glm::vec4(x, y, 1.0f, 1.0f);
    return glm::dvec3(glm::vec3(far) / far.w - scene.camera.eye);
  };
  const glm::dvec3 corner = at_far(-1.0f, 1.0f);
  const glm::dvec3 right = at_far(1.0f, 1.0f) - corner, down = at_far(-1.0f, -1.0f) - corner;
  FloatImage image{width, height, {}};
  image.rgba.reserve(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  constexpr double kStep = 1.0 / kSamplesASide;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      glm::vec3 sum(0.0f);
      for (int sample = 0; sample < kSamplesASide * kSamplesASide; ++sample) {
        const double column = x + kStep * (sample % kSamplesASide + 0.5),
                     row = y + kStep * (sample / kSamplesASide + 0.5);
        const glm::dvec3 d = glm::normalize(corner + column / width * right + row / height * down);
        const glm::dvec3 own(glm::dot(glm::dvec3(axes[0]), d), glm::dot(glm::dvec3(axes[1]), d),
                             glm::dot(glm::dvec3(axes[2]), d));
        sum += radiance(map, environment_coordinates(own));
      }
      sum /= static_cast<float>(kSamplesASide * kSamplesASide);
      image.rgba.insert(image.rgba.end(), {sum.x, sum.y, sum.z, 1.0f});
    }
  return image;
}

FloatImage before_background(const FloatImage& picture, const FloatImage& background) {
  MULTUM_CHECK(picture.rgba.size() == background.rgba.size());
  FloatImage image = picture;
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    image.rgba[i] += (1.0f - picture.rgba[i - i % 4 + 3]) * background.rgba[i];
  return image;
}

}  // namespace multum::gl
