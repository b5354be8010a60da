// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/lobe_rows.h"

#include <algorithm>
#include <cmath>

#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// The numbers of rare numerical events among some lobes.
struct LobeEvents {
  std::uint64_t nonfinite = 0, dead = 0, undirected = 0, clamped = 0;

  void count_gaussian(const MultumVmfLobe& lobe, float kappa_cap) {
    if (!std::isfinite(lobe.mean_x + lobe.mean_y + lobe.mean_z) || !std::isfinite(lobe.amplitude)) ++nonfinite;
    else if (lobe.amplitude < 1e-6f) ++dead;
    else if (lobe.mean_z < 1.0f / kappa_cap) ++clamped;
  }

  void count(const MultumVmfLobe& lobe, float kappa_cap) {
    const float squared = lobe.mean_x * lobe.mean_x + lobe.mean_y * lobe.mean_y + lobe.mean_z * lobe.mean_z;
    if (!std::isfinite(squared) || !std::isfinite(lobe.amplitude)) ++nonfinite;
    else if (lobe.amplitude < 1e-6f) ++dead;
    else if (squared < 1e-6f) ++undirected;
    else if (1.0f - std::sqrt(squared) < 1.0f / kappa_cap) ++clamped;
  }
};

// A share is a sum of many single-precision responsibilities. On a map of 2048 x 2048 texels, the shares of a texel sum
// to values that differ from 1 by up to 7e-6. All other channels have the same relative error, so they are also divided
// by the sum.
void make_shares_sum_to_one(MovmfLevel& level, std::size_t texel) {
  double sum = 0.0;
  for (const auto& lobe : level.lobes) sum += static_cast<double>(lobe[texel].w);
  if (!(sum > 0.0)) return;
  const auto factor = static_cast<float>(1.0 / sum);
  for (auto& lobe : level.lobes) lobe[texel] *= factor;
  for (auto& colour : level.colours) colour[texel] *= factor;
  const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  for (auto& weights : level.weights) {
    const std::size_t count = weights.size() / texels;
    for (std::size_t k = texel * count; k < (texel + 1) * count; ++k) weights[k] *= factor;
  }
}

}  // namespace

MultumVmfLobe fitted_lobe(const glm::vec4& stored, Representation representation) {
  const float inverse = stored.w > 0.0f ? 1.0f / stored.w : 0.0f;
  MultumVmfLobe lobe = {stored.x * inverse, stored.y * inverse, stored.z * inverse, stored.w};
  if (lobe_family(representation).is_planar) lobe.mean_z = gmm_variance(stored);
  return lobe;
}

MovmfLevel stored_rows(const LobeRowsSize& size, const MultumVmfLobe* lobes, const std::vector<glm::vec3>& features,
                       float kappa_cap, int threads, FitReport& report) {
  const auto width = static_cast<std::size_t>(size.width), lobe_count = static_cast<std::size_t>(size.lobe_count);
  const std::size_t texels = width * static_cast<std::size_t>(size.height);
  MovmfLevel out;
  out.width = size.width;
  out.height = size.height;
  out.lobes.resize(lobe_count);
  for (auto& lobe : out.lobes) lobe.resize(texels);
  const std::size_t weight_count = static_cast<std::size_t>(size.weight_count);
  const std::size_t colour_planes = size.has_colours ? 1 : 0;
  const std::size_t rgb_planes = colour_planes + (weight_count + 2) / 3;
  if (size.has_colours) out.colours.assign(lobe_count, std::vector<glm::vec3>(texels));
  if (weight_count > 0) out.weights.assign(lobe_count, std::vector<float>(texels * weight_count));
  const bool is_planar = lobe_family(size.representation).is_planar;
  std::vector<LobeEvents> events(static_cast<std::size_t>(size.height));
  for_each_item(size.height, threads, [&](int y) {
    const auto row = static_cast<std::size_t>(y);
    for (std::size_t j = 0; j < lobe_count; ++j) {
      const MultumVmfLobe* from = &lobes[(row * lobe_count + j) * width];
      glm::vec4* to = &out.lobes[j][row * width];
      for (std::size_t x = 0; x < width; ++x) {
        const MultumVmfLobe& lobe = from[x];
        const float a = lobe.amplitude;
        if (is_planar) {
          const float square = lobe.mean_x * lobe.mean_x + lobe.mean_y * lobe.mean_y;
          to[x] = {a * lobe.mean_x, a * lobe.mean_y, a * (2.0f * lobe.mean_z + square), a};
          events[row].count_gaussian(lobe, kappa_cap);
        } else {
          to[x] = {a * lobe.mean_x, a * lobe.mean_y, a * lobe.mean_z, a};
          events[row].count(lobe, kappa_cap);
        }
      }
      const auto feature_row = [&](std::size_t rgb_plane) {
        return &features[((row * rgb_planes + rgb_plane) * lobe_count + j) * width];
      };
      if (size.has_colours) std::copy_n(feature_row(0), width, &out.colours[j][row * width]);
      for (std::size_t k = 0; k < weight_count; ++k) {
        const glm::vec3* weights = feature_row(colour_planes + k / 3);
        for (std::size_t x = 0; x < width; ++x)
          out.weights[j][(row * width + x) * weight_count + k] = weights[x][static_cast<glm::length_t>(k % 3)];
      }
    }
    for (std::size_t x = row * width; x < (row + 1) * width; ++x) make_shares_sum_to_one(out, x);
  });
  for (const LobeEvents& event : events) {
    report.nonfinite += event.nonfinite;
    report.dead_lobes += event.dead;
    report.undirected_lobes += event.undirected;
    report.kappa_clamped += event.clamped;
  }
  report.lobe_count_total += lobe_count * texels;
  return out;
}

}  // namespace multum
