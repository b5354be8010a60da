// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_basis.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <limits>

#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// The spread at which a lobe's weight is one half. It is approximately the spread of a highlight with s = 100. Errors
// are more visible in sharper lobes.
constexpr float kHalfSpread = 0.02f;

float weight_of(const glm::vec4& lobe) {
  const float spread = std::max(1.0f - glm::length(glm::vec3(lobe)) / lobe.w, 0.0f);
  return 1.0f / (spread + kHalfSpread);
}

template <typename Look>
void each_lobe(const MovmfMipmap& mipmap, int first_level, int lobe, const Look& look) {
  for (std::size_t l = size_of(first_level); l < mipmap.levels.size(); ++l)
    for (const glm::vec4& one : mipmap.levels[l].lobes[size_of(lobe)])
      if (one.w > 0.0f) look(one);
}

}  // namespace

glm::vec4 moments_of(const glm::vec4& lobe) { return {lobe.x, lobe.y, lobe.w - lobe.z, lobe.w}; }

glm::vec4 LobeBasis::reduced(const glm::vec4& m) const {
  return {m.x - mean.x * m.w, m.y - mean.y * m.w, m.z - glm::dot(predictor, glm::vec3(m.x, m.y, m.w)), m.w};
}

LobeBasis fit_lobe_basis(const MovmfMipmap& mipmap, int first_level, int lobe) {
  glm::dmat3 normal(0.0);  // sums of weighted products of x, y, a
  glm::dvec3 right(0.0);   // sums of weighted products of x, y, a with s
  each_lobe(mipmap, first_level, lobe, [&](const glm::vec4& one) {
    const glm::dvec4 m = moments_of(one);
    const glm::dvec3 known(m.x, m.y, m.w);
    const double weight = static_cast<double>(weight_of(one));
    normal += weight * glm::outerProduct(known, known);
    right += weight * m.z * known;
  });
  LobeBasis basis;
  const double amplitude = normal[2][2];
  if (amplitude <= 0.0) return basis;  // the lobe has no amplitude in any texel
  // Adds a ridge of 1e-6, so that a channel that is 0 everywhere is not used for prediction.
  for (int i = 0; i < 3; ++i) normal[i][i] += 1e-6 * amplitude;
  basis.mean = glm::dvec2(normal[2]) / amplitude;
  basis.predictor = glm::inverse(normal) * right;
  // A texel without the lobe stores 0 in all channels.
  basis.low = glm::vec4(0.0f);
  basis.high = glm::vec4(std::numeric_limits<float>::min());
  each_lobe(mipmap, first_level, lobe, [&](const glm::vec4& one) {
    const glm::vec4 values = basis.reduced(moments_of(one));
    basis.low = glm::min(basis.low, values);
    basis.high = glm::max(basis.high, values);
  });
  return basis;
}

LobeUnpacking unpacking_of(const LobeBasis& basis) {
  // Returns the lobe (x, y, z, a) for the moments (x, y, s, a) that one channel contributes.
  const auto lobe_of = [&](float x, float y, float s, float a) {
    const float full_x = x + basis.mean.x * a, full_y = y + basis.mean.y * a;
    const float full_s = s + glm::dot(basis.predictor, glm::vec3(full_x, full_y, a));
    return glm::vec4(full_x, full_y, a - full_s, a);
  };
  const glm::vec4 range = basis.high - basis.low;
  return {
      {{lobe_of(range.x, 0, 0, 0), lobe_of(0, range.y, 0, 0), lobe_of(0, 0, range.z, 0), lobe_of(0, 0, 0, range.w)}},
      lobe_of(basis.low.x, basis.low.y, basis.low.z, basis.low.w)};
}

LobeUnpacking plain_unpacking() {
  return {{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}, {0, 0, 1, 1}}}, glm::vec4(0.0f)};
}

}  // namespace multum
