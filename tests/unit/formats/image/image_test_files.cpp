// SPDX-License-Identifier: Apache-2.0
// See image_test_files.h.
#include "tests/unit/formats/image/image_test_files.h"

#include <cmath>
#include <numbers>

namespace multum::testing {

void write_test_image(const std::string& path, const TestImage& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, image.type);
  if (!image.channel_names.empty()) spec.channelnames = image.channel_names;
  spec.alpha_channel = image.alpha_channel;
  if (image.alpha_channel >= 0) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (image.tile_size > 0) spec.tile_width = spec.tile_height = image.tile_size;
  if (image.tile_size > 0) spec.tile_depth = 1;
  if (!image.compression.empty()) spec.attribute("compression", image.compression);
  if (!image.colour_space.empty()) spec.attribute("oiio:ColorSpace", image.colour_space);
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output) << OIIO::geterror();
  ASSERT_TRUE(output->open(path, spec)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.values.data())) << output->geterror();
  ASSERT_TRUE(output->close()) << output->geterror();
}

std::vector<glm::dvec3> surface_normals(int width, int height, double steepness) {
  std::vector<glm::dvec3> normals;
  const double u_step = 2.0 * std::numbers::pi / width;
  const double v_step = 2.0 * std::numbers::pi / height;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      // h = sin(2u + v) / 2 + cos(u - 2v) / 3 + sin(u) cos(v), v downwards; slopes are per radian, which sets the
      // scale.
      const double u = column * u_step;
      const double v = row * v_step;
      const double hu = std::cos(2 * u + v) - std::sin(u - 2 * v) / 3 + std::cos(u) * std::cos(v);
      const double hv = std::cos(2 * u + v) / 2 + std::sin(u - 2 * v) * 2 / 3 - std::sin(u) * std::sin(v);
      const glm::dvec3 n(-steepness * hu, steepness * hv, 1.0);
      normals.push_back(n / std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z));
    }
  }
  return normals;
}

TestImage normal_image(int width, int height, bool is_signed, double green_sign) {
  TestImage image;
  image.width = width;
  image.height = height;
  for (glm::dvec3 n : surface_normals(width, height)) {
    n.y *= green_sign;
    if (!is_signed) n = n * 0.5 + 0.5;
    for (const double v : {n.x, n.y, n.z}) image.values.push_back(static_cast<float>(v));
  }
  return image;
}

double largest_difference(const NormalMap& map, const std::vector<glm::dvec3>& normals) {
  if (map.x.size() != normals.size()) return 1e30;
  double largest = 0.0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double dx = static_cast<double>(map.x[i]) - normals[i].x;
    const double dy = static_cast<double>(map.y[i]) - normals[i].y;
    const double dz = static_cast<double>(map.z[i]) - normals[i].z;
    largest = std::max(largest, std::sqrt(dx * dx + dy * dy + dz * dz));
  }
  return largest;
}

NormalMap read_map(const std::string& path, const NormalMapSettings& settings) {
  return read_normal_map(path, settings, 2, nullptr);
}

}  // namespace multum::testing
