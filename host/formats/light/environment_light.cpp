// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/environment_light.h"

#include <ctime>
#include <utility>

#include <glm/common.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

EnvironmentMap mixed(const EnvironmentMap& a, const EnvironmentMap& b, float share) {
  MULTUM_CHECK(a.width == b.width && a.height == b.height);
  EnvironmentMap map{a.width, a.height, {}};
  map.texels.reserve(a.texels.size());
  for (std::size_t i = 0; i < a.texels.size(); ++i) map.texels.push_back(glm::mix(a.texels[i], b.texels[i], share));
  return map;
}

PrefilteredLevels mixed(const PrefilteredLevels& a, const PrefilteredLevels& b, float share) {
  PrefilteredLevels levels{{}, a.spreads};
  for (std::size_t l = 0; l < a.levels.size(); ++l) levels.levels.push_back(mixed(a.levels[l], b.levels[l], share));
  return levels;
}

SmoothEnvironment mixed(const SmoothEnvironment& a, const SmoothEnvironment& b, double share) {
  SmoothEnvironment smooth;
  for (std::size_t c = 0; c < 3; ++c) {
    smooth.mean[c] = glm::mix(a.mean[c], b.mean[c], share);
    smooth.linear[c] = glm::mix(a.linear[c], b.linear[c], share);
    smooth.quadratic[c] = (1.0 - share) * a.quadratic[c] + share * b.quadratic[c];
  }
  return smooth;
}

}  // namespace

std::shared_ptr<const EnvironmentLight> make_environment_light(EnvironmentMap map) {
  const double start = processor_seconds();
  const EnvironmentMap shown = shrink(map, kEnvironmentWidthMax);
  EnvironmentLight light{
      std::move(map), prefilter(shown), shrink(shown, 64), smooth_environment(shown), LightSampler(shown), 0.0};
  light.processor_seconds = processor_seconds() - start;
  return std::make_shared<const EnvironmentLight>(std::move(light));
}

std::shared_ptr<const EnvironmentLight> mix_environments(const std::shared_ptr<const EnvironmentLight>& a,
                                                         const std::shared_ptr<const EnvironmentLight>& b,
                                                         double share) {
  if (a == b || share <= 0.0) return a;
  if (share >= 1.0) return b;
  const double start = processor_seconds();
  const auto part = static_cast<float>(share);
  EnvironmentLight light{
      mixed(a->map, b->map, part),        mixed(a->levels, b->levels, part),           mixed(a->small, b->small, part),
      mixed(a->smooth, b->smooth, share), LightSampler(a->sampler, b->sampler, share), 0.0};
  light.processor_seconds = processor_seconds() - start;
  return std::make_shared<const EnvironmentLight>(std::move(light));
}

}  // namespace multum
