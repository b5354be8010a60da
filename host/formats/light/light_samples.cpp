// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/light_samples.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

// Returns a multiple of one of Roberts' R3 ratios, modulo 1.
double fraction(unsigned index, double ratio) {
  const double x = 0.5 + ratio * (static_cast<double>(index) + 1.0);
  return x - std::floor(x);
}

}  // namespace

double sampled_luminance(const glm::dvec3& light) { return (light.x + light.y + light.z) / 3.0; }

LightSampler::LightSampler(const EnvironmentMap& map) : width_(map.width), height_(map.height) {
  double sum = 0.0;
  cumulative_.reserve(map.texels.size());
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      sum +=
          texel_solid_angle(map.width, map.height, y) * sampled_luminance(glm::dvec3(map.texels[cumulative_.size()]));
      cumulative_.push_back(sum);
    }
}

LightSampler::LightSampler(const LightSampler& a, const LightSampler& b, double share)
    : width_(a.width_), height_(a.height_) {
  MULTUM_CHECK(a.width_ == b.width_ && a.height_ == b.height_);
  cumulative_.reserve(a.cumulative_.size());
  for (std::size_t i = 0; i < a.cumulative_.size(); ++i)
    cumulative_.push_back((1.0 - share) * a.cumulative_[i] + share * b.cumulative_[i]);
}

// Finds the texel by inverting the cumulative sum. Then draws uniformly in longitude and in the cosine of latitude.
glm::dvec3 LightSampler::direction(unsigned index) const {
  const double u = fraction(index, 0.8191725133961645) * total();
  const auto found = std::upper_bound(cumulative_.begin(), cumulative_.end(), u);
  const int i =
      static_cast<int>(std::min(found - cumulative_.begin(), static_cast<std::ptrdiff_t>(cumulative_.size()) - 1));
  const int x = i % width_, y = i / width_;
  const double top = std::cos(std::numbers::pi * y / height_), bottom = std::cos(std::numbers::pi * (y + 1) / height_);
  const double cosine = top + (bottom - top) * fraction(index, 0.6710436067037893);
  return environment_direction((x + fraction(index, 0.5497004779019703)) / width_,
                               std::acos(std::clamp(cosine, -1.0, 1.0)) / std::numbers::pi);
}

}  // namespace multum
