// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/bake_cost.h"

#include <algorithm>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/lobes/lobe_family.h"

namespace multum {
namespace {

// Times in nanoseconds per finest texel, fitted by eye to bakes of the four-quarter map with 2048 and 4096 texels per
// side. The bakes ran on 2 cores of an otherwise idle Intel Xeon with AVX-512 and PoCL 3.1 (docs/evidence/SCENE.md).
constexpr double kRead = 55.0;          // a map of three channels
constexpr double kAveragePlane = 18.0;  // per averaged plane
constexpr double kFitLevelOne = 80.0;   // level 1, whose texels assign each of four normals to a lobe
constexpr double kFitLobeOne = 20.0;    // additional time per lobe
constexpr double kFitFine = 60.0;       // each level from 2 to 5, which is fitted to all normals
constexpr double kFitLobeFine = 15.0;
constexpr double kFitCoarse = 60.0;        // all coarser levels together, which are fitted to binned normals
constexpr double kColourFactor = 0.6;      // additional share per triple of features
constexpr double kWriteTexture = 30.0;     // per stored texel of a texture
constexpr double kMeasureLambert = 5.0;    // for Lambert
constexpr double kMeasureExponent = 15.0;  // per exponent
constexpr double kFixedMs = 120.0;         // loading programs, making buffers, and finding the start of EM

double level_texels(const BakeShape& s, int first_level) {
  double texels = 0.0;
  for (int l = first_level; l < mip_level_count(s.width, s.height); ++l)
    texels += static_cast<double>(mip_level_size(s.width, l)) * mip_level_size(s.height, l);
  return texels;
}

bool is_fitted(const BakeShape& s) {
  const LobeFamily* const family = representation_info(s.representation).lobes;
  return family != nullptr && !(family->one_lobe_is_mean && s.lobe_count == 1);
}

double fit_ns(const BakeShape& s, int rgb_planes) {
  const auto lobes = static_cast<double>(s.lobe_count);
  double ns = kFitCoarse;
  if (s.first_level <= 1) ns += kFitLevelOne + kFitLobeOne * lobes;
  ns += std::clamp(6 - std::max(s.first_level, 2), 0, 4) * (kFitFine + kFitLobeFine * lobes);
  return ns * (1.0 + kColourFactor * rgb_planes);
}

double plane_count(const BakeShape& s, int rgb_planes) {
  return representation_info(s.representation).mean_count({s.lobe_count, s.sh_order}) + 3.0 * rgb_planes;
}

}  // namespace

int texture_count(const BakeShape& s) {
  return texture_count(s.representation, {s.lobe_count, s.sh_order},
                       (s.has_colours ? 1 : 0) + (s.weight_count > 0 ? 1 : 0));
}

BakeCost bake_cost(const BakeShape& s) {
  const double texels = static_cast<double>(s.width) * s.height;
  const int rgb_planes = (s.has_colours ? 1 : 0) + (s.weight_count + 2) / 3;
  const double stored = level_texels(s, s.first_level) * texture_count(s);
  const double mean_colours = s.mean_colours ? level_texels(s, 0) : 0.0;
  double ns = texels * kRead * (1.0 + (s.has_colours || s.mean_colours ? 1.0 : 0.0) + (s.weight_count > 0 ? 1.0 : 0.0));
  ns += texels * (is_fitted(s) ? fit_ns(s, rgb_planes) : kAveragePlane * plane_count(s, rgb_planes));
  if (s.mean_colours) ns += texels * 3.0 * kAveragePlane;
  ns += (stored + mean_colours) * kWriteTexture;
  ns += texels * (kMeasureLambert + kMeasureExponent * s.exponent_count) * (s.has_colours ? 3.0 : 1.0);
  const double value_bytes = s.encoding == StorageEncoding::kFloat ? 4.0 : 2.0;
  return {kFixedMs + ns * 1e-6, (stored * value_bytes + mean_colours * 2.0) * 4.0};
}

}  // namespace multum
