// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/prefiltered_levels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/formats/brdf/vmf_terms.h"

namespace multum {
namespace {

// Returns a map whose texels are means of the source, weighted by the lobe and by solid angle. The division by the sum
// of the weights leaves a constant map unchanged. Texels farther away than four standard deviations are ignored.
EnvironmentMap convolve(const EnvironmentMap& source, double kappa, int width, int height) {
  EnvironmentMap result{width, height, std::vector<glm::vec3>(static_cast<std::size_t>(width * height))};
  const double reach = std::min(4.0 / std::sqrt(kappa), std::numbers::pi);
  std::vector<double> sine(static_cast<std::size_t>(source.width)), cosine(sine.size());
  for (std::size_t u = 0; u < sine.size(); ++u) {
    const double phi = 2.0 * std::numbers::pi * ((static_cast<double>(u) + 0.5) / source.width - 0.5);
    sine[u] = std::sin(phi);
    cosine[u] = std::cos(phi);
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double theta = std::numbers::pi * (y + 0.5) / height,
                   phi = 2.0 * std::numbers::pi * ((x + 0.5) / width - 0.5);
      const double sin_phi = std::sin(phi), cos_phi = std::cos(phi);
      const int top = std::max(0, static_cast<int>((theta - reach) / std::numbers::pi * source.height));
      const int bottom =
          std::min(source.height - 1, static_cast<int>((theta + reach) / std::numbers::pi * source.height));
      glm::dvec3 sum(0.0);
      double total = 0.0;
      for (int v = top; v <= bottom; ++v) {
        const double row = std::numbers::pi * (v + 0.5) / source.height;
        const double across = std::sin(row) * std::sin(theta), along = std::cos(row) * std::cos(theta);
        const double angle = texel_solid_angle(source.width, source.height, v);
        // cos(angle between) >= cos(reach) limits the longitudes.
        const double bound = across > 1e-9 ? (std::cos(reach) - along) / across : -2.0;
        const double half = bound <= -1.0 ? std::numbers::pi : bound >= 1.0 ? 0.0 : std::acos(bound);
        const int columns =
            std::min(source.width / 2, static_cast<int>(half / (2.0 * std::numbers::pi) * source.width) + 1);
        const int centre = static_cast<int>((x + 0.5) / width * source.width);
        const bool all = 2 * columns + 1 >= source.width;
        const int first = all ? 0 : centre - columns, last = all ? source.width - 1 : centre + columns;
        for (int u = first; u <= last; ++u) {
          const auto column = static_cast<std::size_t>((u + source.width) % source.width);
          const double t = along + across * (cosine[column] * cos_phi + sine[column] * sin_phi);
          const double weight = angle * std::exp(kappa * (t - 1.0));
          sum += weight * glm::dvec3(source.texels[static_cast<std::size_t>(v) * sine.size() + column]);
          total += weight;
        }
      }
      result.texels[static_cast<std::size_t>(y * width + x)] = glm::vec3(sum / total);
    }
  return result;
}

}  // namespace

// Makes each level from the previous level. Mean cosines multiply, so the mean cosine of the lobe of a step is the
// quotient of two mean cosines.
PrefilteredLevels prefilter(const EnvironmentMap& map) {
  const double texel = std::numbers::pi / map.height;
  PrefilteredLevels result{{map}, {texel * texel / 12.0}};  // level 0 has the spread of a box, because a texel is a box
  for (int k = 1; (map.height >> k) >= 4; ++k) {
    const int width = map.width >> k, height = map.height >> k;  // sizes are rounded as in OpenGL
    const double deviation = 2.0 * std::numbers::pi / height;
    const double spread = vmf_spread(1.0 / (deviation * deviation));
    const double step = 1.0 - (1.0 - spread) / (1.0 - result.spreads.back());
    result.levels.push_back(convolve(result.levels.back(), vmf_kappa(step), width, height));
    result.spreads.push_back(spread);
  }
  return result;
}

}  // namespace multum
