// SPDX-License-Identifier: Apache-2.0
// Implements the lookups and the shading of multum.h.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "host/api/api_call.h"
#include "host/api/api_error.h"
#include "host/api/api_map.h"
#include "host/api/lobe_shading.h"

namespace multum {

void check_has_lobes(const multum_map& map) {
  if (map.header().representation != Representation::kMovmf)
    throw Error(ErrorCode::kUsage,
                fmt::format("{} has representation {}, expected lobes (vmf)", map.path(), map.text("representation")));
}

namespace {

glm::dvec3 vector_of(const double* v) { return {v[0], v[1], v[2]}; }
void store(const glm::dvec3& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

struct Taps {
  int texels[2];
  double weights[2];
};

Taps taps_of(double place, int size, WrapMode mode) {
  const double x = place * size - 0.5, first = std::floor(x);
  const int i = static_cast<int>(std::clamp(first, -1e9, 1e9));
  // Returns -1 for a texel beyond a black border.
  const auto texel = [&](int at) {
    return mode == WrapMode::kBlack && (at < 0 || at >= size) ? -1 : wrapped_texel(at, size, mode);
  };
  return {{texel(i), texel(i + 1)}, {1.0 - (x - first), x - first}};
}

// Adds one level, filtered bilinearly, to sums of [lobe][4] and [lobe][3].
void add_level(multum_map& map, int level, double u, double v, double share, double (*lobes)[4], double (*colours)[3]) {
  const PartValues& values = map.level(level);
  const BakedHeader& header = map.header();
  const int width = mip_level_size(header.width, level), height = mip_level_size(header.height, level);
  const Taps xs = taps_of(u, width, header.wrap_s), ys = taps_of(v, height, header.wrap_t);
  const std::size_t layer = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const int count = map.info().lobe_count;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) {
      if (ys.texels[y] < 0 || xs.texels[x] < 0) continue;
      const double weight = share * ys.weights[y] * xs.weights[x];
      const std::size_t texel = static_cast<std::size_t>(ys.texels[y]) * static_cast<std::size_t>(width) +
                                static_cast<std::size_t>(xs.texels[x]);
      for (int j = 0; j < count; ++j) {
        const std::size_t at = static_cast<std::size_t>(j) * layer + texel;
        const float* const lobe = values[MULTUM_LOBES].data() + 4 * at;
        for (int c = 0; c < 4; ++c) lobes[j][c] += weight * static_cast<double>(lobe[c]);
        if (!header.has_colours) continue;
        const float* const colour = values[MULTUM_COLOURS].data() + 3 * at;
        for (int c = 0; c < 3; ++c) colours[j][c] += weight * static_cast<double>(colour[c]);
      }
    }
}

void look_up(multum_map& map, double u, double v, double level, multum_lobes& result) {
  check_has_lobes(map);
  if (!std::isfinite(u) || !std::isfinite(v) || std::isnan(level))
    throw Error(ErrorCode::kUsage,
                fmt::format("multum_map_lookup: (u, v, level) is ({}, {}, {}), expected finite numbers", u, v, level));
  const int last = map.header().level_count() - 1;
  const double lod = std::clamp(level, static_cast<double>(map.header().first_level), static_cast<double>(last));
  const int finer = static_cast<int>(lod);
  const double share = lod - finer;
  double lobes[MULTUM_LOBES_MAX][4] = {}, colours[MULTUM_LOBES_MAX][3] = {};
  // Keeps coordinates precise far from the origin.
  u -= map.header().wrap_s == WrapMode::kPeriodic ? std::floor(u) : 0.0;
  v -= map.header().wrap_t == WrapMode::kPeriodic ? std::floor(v) : 0.0;
  add_level(map, finer, u, v, 1.0 - share, lobes, colours);
  if (share > 0.0) add_level(map, finer + 1, u, v, share, lobes, colours);
  result.count = map.info().lobe_count;
  result.has_colours = map.header().has_colours ? 1 : 0;
  result.mean_cosine = map.header().has_roughness ? map.header().mean_cosine : 0.0f;
  for (int j = 0; j < MULTUM_LOBES_MAX; ++j) {
    for (int c = 0; c < 4; ++c) result.lobes[j][c] = static_cast<float>(lobes[j][c]);
    for (int c = 0; c < 3; ++c) result.colours[j][c] = static_cast<float>(colours[j][c]);
  }
}

}  // namespace
}  // namespace multum

using multum::guarded;

multum_status multum_map_lookup(multum_map* map, double u, double v, double level, multum_lobes* lobes,
                                multum_error** error) {
  return guarded(error, [&] {
    multum::require(map, "multum_map_lookup", "map", "a map");
    multum::require(lobes, "multum_map_lookup", "lobes", "a place for the result");
    multum::look_up(*map, u, v, level, *lobes);
  });
}

multum_status multum_brdf_new(const char* text, multum_brdf** brdf, multum_error** error) {
  return guarded(error, [&] {
    multum::require(text, "multum_brdf_new", "text", "a BRDF, such as ggx:0.4");
    multum::require(brdf, "multum_brdf_new", "brdf", "a place for the result");
    const multum::ApiCall call(nullptr);
    *brdf = std::make_unique<multum_brdf>(multum::shaded_brdf(text)).release();
  });
}

void multum_brdf_free(multum_brdf* brdf) { delete brdf; }

void multum_shade(const multum_lobes* lobes, const multum_brdf* brdf, const double light[3], const double view[3],
                  double rgb[3]) {
  multum::store(multum::shade_lobes(*lobes, *brdf, multum::vector_of(light), multum::vector_of(view)), rgb);
}

double multum_density(const multum_lobes* lobes, const double normal[3]) {
  return multum::lobe_density(*lobes, multum::vector_of(normal));
}

double multum_sample(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3], const double random[3],
                     double light[3]) {
  glm::dvec3 l(0.0, 0.0, 1.0);
  const double pdf = multum::sample_lobes(*lobes, *brdf, multum::vector_of(view), multum::vector_of(random), l);
  multum::store(l, light);
  return pdf;
}

double multum_pdf(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3], const double light[3]) {
  return multum::lobe_pdf(*lobes, *brdf, multum::vector_of(view), multum::vector_of(light));
}
