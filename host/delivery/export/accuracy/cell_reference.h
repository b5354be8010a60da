// SPDX-License-Identifier: Apache-2.0
// The reference of one texel of a level: the mean highlight of all that it covers of the finest texels, each by its own
// roughness, under lights that are drawn where the highlights are.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/delivery/export/accuracy/lobe_shading.h"
#include "host/formats/image/plane_store.h"

namespace multum {

/// Length of finest texel [index, index + 1) within texel `texel` of a side of `to` texels; the finest has `from`.
double covered_length(int index, int texel, int from, int to);

/// Finest texels under a texel, and their means.
struct CoveredFacets {
  std::vector<glm::dvec3> normals;    // unit
  std::vector<double> alpha_squared;  // >= kAlphaMin^2
  std::vector<double> weights;        // areas; their sum is 1
  glm::dvec3 mean_normal{0.0};
  double mean_roughness = 0.0;  // perceptual
  double mean_alpha_squared = 0.0;
};

/// Of texel (x, y) of a level `width` by `height`. `material`: null, or its first plane is alpha^2; else all have
/// `alpha_squared`.
CoveredFacets covered_facets(const PlaneStore& normals, const PlaneStore* material, double alpha_squared, int width,
                             int height, int x, int y);

/// Lights of several views and the reference under them.
struct ReferenceLights {
  std::vector<LightSet> views;
  std::vector<std::vector<double>> values;  // mean highlights, view by view
  double total = 0.0;                       // the integral of the reference over lights and views
  double noise = 0.0;                       // its standard error, over itself
};

/// Point lights: three quarters drawn from the covered facets, by the distribution of visible half vectors, a quarter
/// from a lobe wider than they are together. `seed`: lights of another seed are others.
ReferenceLights point_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed);

/// Lights 20 degrees across, `points` of each one: neighbours in the list. Their shares are those of the whole light.
ReferenceLights wide_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed);
constexpr std::size_t kWideLightPoints = 16;

/// What a lobe's highlight differs from the reference.
struct LobeError {
  double error = 0.0;   // relative L1: the integral of |lobe - reference| over that of the reference
  double energy = 0.0;  // the integral of the lobe over that of the reference
};

/// Highlights of a view's lights, light by light.
using HighlightsOf = std::function<void(const LightSet& lights, std::vector<double>& values)>;

/// `points`: neighbours that make one light: 1, or kWideLightPoints.
LobeError error_of_highlights(const ReferenceLights& lights, const HighlightsOf& highlights_of, std::size_t points = 1);
LobeError error_of_lobe(const ReferenceLights& lights, const GgxLobe& lobe, std::size_t points = 1);

}  // namespace multum
