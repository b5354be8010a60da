// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/sh_test_map.h"

#include "host/lab/reference/spherical_harmonics.h"

namespace multum::gl {

ShMipmap make_harmonics(const NormalImage& image, int order, StorageEncoding encoding, double mean_cosine) {
  ShMipmap mipmap;
  mipmap.header.representation = Representation::kSh;
  mipmap.header.encoding = encoding;
  mipmap.header.wrap_s = image.wrap_s;
  mipmap.header.wrap_t = image.wrap_t;
  mipmap.header.width = image.width;
  mipmap.header.height = image.height;
  mipmap.header.has_colours = !image.albedo.empty();
  mipmap.header.has_roughness = mean_cosine < 1.0;
  mipmap.header.mean_cosine = static_cast<float>(mean_cosine);
  mipmap.order = order;
  const ZonalCoefficients zonal = zonal_vmf(order, mean_cosine);
  mipmap.levels = empty_sh_levels(image.width, image.height);
  std::vector<std::vector<double>> basis;
  for (const glm::vec3& n : image.normals) {
    basis.push_back(reference::sh_basis_to(order, glm::dvec3(n)));
    for (int l = 1; l <= order; ++l)
      for (int m = -l; m <= l; ++m)
        basis.back()[static_cast<std::size_t>(sh_coefficient(l, m))] *= zonal[static_cast<std::size_t>(l)];
  }
  for (ShLevel& level : mipmap.levels) {
    const int across = image.width / level.width, down = image.height / level.height;
    const auto texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
    level.parts.assign(static_cast<std::size_t>(sh_part_count(order)), std::vector<glm::vec4>(texels, glm::vec4(0.0f)));
    if (mipmap.header.has_colours) level.colours.resize(texels);
    for (std::size_t i = 0; i < image.normals.size(); ++i) {
      const auto x = static_cast<int>(i) % image.width / across, y = static_cast<int>(i) / image.width / down;
      const auto texel = static_cast<std::size_t>(y * level.width + x);
      const float share = 1.0f / static_cast<float>(across * down);
      for (std::size_t k = 0; k < basis[i].size(); ++k)
        level.parts[k / 4][texel][static_cast<int>(k % 4)] += share * static_cast<float>(basis[i][k]);
      if (mipmap.header.has_colours) level.colours[texel] += share * image.albedo[i];
    }
    quantize_sh(level, encoding, 1);
  }
  return mipmap;
}

}  // namespace multum::gl
