// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/report/surface_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/export_accuracy.h"
#include "host/delivery/export/accuracy/lobe_shading.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/formats/brdf/ggx_lobe_specular.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

constexpr double kViewTilt = 30.0;         // angle between eye direction and surface normal, degrees
constexpr double kHalfVectorReach = 0.45;  // slope of the half vector at the picture's border, relative to the middle

glm::dvec3 eye() {
  constexpr double kTilt = kViewTilt * std::numbers::pi / 180.0;
  return {0.0, std::sin(kTilt), std::cos(kTilt)};
}

// Returns the direction of the light that a pixel's half vector reflects to the eye. y points up, but rows are counted
// downwards.
glm::dvec3 light_of(const FrameView& view, int x, int y) {
  const auto place = [](int pixel) { return 2.0 * (pixel + 0.5) / kFrameSide - 1.0; };
  const glm::dvec3 half = glm::normalize(glm::dvec3(view.half_vector.x + kHalfVectorReach * place(x),
                                                    view.half_vector.y - kHalfVectorReach * place(y), 1.0));
  return 2.0 * glm::dot(eye(), half) * half - eye();
}

LightSet one_light(const glm::dvec3& light) {
  LightSet set;
  set.view = eye();
  set.add(light);
  return set;
}

// Adds the weighted highlights of adjacent facets under one light, like add_highlights(). The inner loop is over
// facets. `base` holds alpha^2 of each facet. If it is null, all facets have `alpha_squared`.
MULTUM_VECTOR_CLONES double facets_highlight(const glm::dvec3& l, const glm::dvec3& v, const glm::dvec3& h,
                                             const float* x, const float* y, const float* z, const float* base,
                                             double alpha_squared, const double* shares, std::size_t count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto nx = static_cast<double>(x[i]), ny = static_cast<double>(y[i]), nz = static_cast<double>(z[i]);
    const double a2 = base != nullptr ? std::max(kAlphaMin * kAlphaMin, static_cast<double>(base[i])) : alpha_squared;
    const double nl = nx * l.x + ny * l.y + nz * l.z, nv = nx * v.x + ny * v.y + nz * v.z;
    const double nh = nx * h.x + ny * h.y + nz * h.z, d = nh * nh * (a2 - 1.0) + 1.0;
    const double lit = nl > 0.0 && nv > 0.0 && nh > 0.0 ? nl : 0.0;
    const double masking = lit * std::sqrt(a2 + (1.0 - a2) * nv * nv);
    const double shadowing = std::abs(nv) * std::sqrt(a2 + (1.0 - a2) * lit * lit);
    sum += shares[i] * a2 / (std::numbers::pi * d * d) * 0.5 * lit / (masking + shadowing + 1e-300);
  }
  return sum;
}

// Returns a texture's normal as a shader decodes it.
glm::dvec3 normal_of(const double* values) {
  const glm::dvec3 normal(values[0], values[1], values[2]);
  return glm::length(normal) > 1e-9 ? glm::normalize(normal) : glm::dvec3(0.0, 0.0, 1.0);
}

double alpha_of(double roughness) { return std::max(kAlphaMin, roughness * roughness); }

GgxLobe lobe_of_values(const double* values, bool has_axis) {
  const double alpha = alpha_of(values[3]);
  GgxLobe lobe = GgxLobe::isotropic(normal_of(values), alpha);
  if (!has_axis) return lobe;
  lobe.alpha_wide = alpha + (1.0 - alpha) * values[6] * values[6];
  const double length = std::hypot(values[4], values[5]);
  if (length > 1e-6) lobe.axis = (values[4] * lobe.axis + values[5] * glm::cross(lobe.normal, lobe.axis)) / length;
  return lobe;
}

double baked_highlight(const glm::dvec3& light, const double* values, int lobe_count, double alpha) {
  const glm::dvec3 half = glm::normalize(light + eye());
  double sum = 0.0;
  for (int j = 0; j < lobe_count; ++j)
    sum += GgxOverLobe({values[4 * j], values[4 * j + 1], values[4 * j + 2], values[4 * j + 3]}, alpha)
               .specular(light, eye(), half);
  return sum;
}

// The finest texels that a pixel's side covers, with their shares.
struct CoveredSide {
  std::vector<int> texels;  // indices within the map, which repeats
  std::vector<double> shares;
};

CoveredSide covered_side(double begin, double side, int size) {
  CoveredSide covered;
  for (auto texel = static_cast<std::int64_t>(std::floor(begin)); static_cast<double>(texel) < begin + side; ++texel) {
    const auto from = static_cast<double>(texel);
    const double length = std::min(from + 1.0, begin + side) - std::max(from, begin);
    if (length <= 0.0) continue;
    covered.texels.push_back(static_cast<int>((texel % size + size) % size));
    covered.shares.push_back(length / side);
  }
  return covered;
}

}  // namespace

FramePixels draw_model(const SurfaceModel& model, const LevelTexture& averages, const FrameView& view, int map_width,
                       int map_height, int threads) {
  FramePixels pixels(size_of(kFrameSide) * size_of(kFrameSide));
  const double side = std::exp2(view.level);
  for_each_item(kFrameSide, threads, [&](int y) {
    std::vector<double> values(size_of(model.texture.channel_count())), means(size_of(averages.channel_count()));
    std::vector<double> highlight;
    const bool has_axis = model.texture.channel_count() > 4;
    for (int x = 0; x < kFrameSide; ++x) {
      const double u = (view.middle.x + (x + 0.5 - 0.5 * kFrameSide) * side) / map_width;
      const double v = (view.middle.y + (y + 0.5 - 0.5 * kFrameSide) * side) / map_height;
      model.texture.sample(view.level, u, v, values.data());
      const glm::dvec3 light = light_of(view, x, y);
      double& pixel = pixels[size_of(y) * size_of(kFrameSide) + size_of(x)];
      if (model.kind != SurfaceModel::Kind::kBakedLobes) {
        highlights(one_light(light), lobe_of_values(values.data(), has_axis), highlight);
        pixel = highlight[0];
        continue;
      }
      averages.sample(view.level, u, v, means.data());
      pixel = baked_highlight(light, values.data(), model.texture.channel_count() / 4, alpha_of(means[3]));
    }
  });
  return pixels;
}

FramePixels draw_reference(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                           const FrameView& view, int threads) {
  FramePixels pixels(size_of(kFrameSide) * size_of(kFrameSide));
  const double side = std::exp2(view.level);
  const double a2 = std::max(kAlphaMin * kAlphaMin, alpha_squared);
  const int width = normals.width();
  for_each_item(kFrameSide, threads, [&](int y) {
    const CoveredSide rows = covered_side(view.middle.y + (y - 0.5 * kFrameSide) * side, side, normals.height());
    std::vector<CoveredSide> columns;
    for (int x = 0; x < kFrameSide; ++x)
      columns.push_back(covered_side(view.middle.x + (x - 0.5 * kFrameSide) * side, side, width));
    std::vector<float> nx(size_of(width)), ny(nx), nz(nx), base(nx);
    for (std::size_t r = 0; r < rows.texels.size(); ++r) {
      normals.read_rows(rows.texels[r], 1, {nx.data(), ny.data(), nz.data()});
      if (material != nullptr) material->read_rows(0, rows.texels[r], 1, base.data());
      for (int x = 0; x < kFrameSide; ++x) {
        const CoveredSide& column = columns[size_of(x)];
        const glm::dvec3 light = light_of(view, x, y), half = glm::normalize(light + eye());
        double& pixel = pixels[size_of(y) * size_of(kFrameSide) + size_of(x)];
        for (std::size_t c = 0; c < column.texels.size();) {  // a run of adjacent texels ends at the map's border
          const std::size_t at = size_of(column.texels[c]);
          const std::size_t count = std::min(column.texels.size() - c, size_of(width) - at);
          pixel += rows.shares[r] * facets_highlight(light, eye(), half, &nx[at], &ny[at], &nz[at],
                                                     material != nullptr ? &base[at] : nullptr, a2, &column.shares[c],
                                                     count);
          c += count;
        }
      }
    }
  });
  return pixels;
}

}  // namespace multum
