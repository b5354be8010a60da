// SPDX-License-Identifier: Apache-2.0
// Computes the reference highlight of one texel of a level. The reference is the mean highlight of all finest texels
// that the texel covers, each with its own roughness. Lights are sampled in directions in which the highlights are
// bright.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/delivery/export/accuracy/lobe_shading.h"
#include "host/formats/image/plane_store.h"

namespace multum {

/// Returns, along one axis, the share of texel `index` of the finest level that is inside texel `texel` of a coarser
/// level. The finest level has `from` texels, and the coarser level has `to` texels.
double covered_length(int index, int texel, int from, int to);

/// The finest texels that a texel covers, and their means.
struct CoveredFacets {
  std::vector<glm::dvec3> normals;    // unit vectors
  std::vector<double> alpha_squared;  // >= kAlphaMin^2
  std::vector<double> weights;        // shares of the area; their sum is 1
  glm::dvec3 mean_normal{0.0};
  double mean_roughness = 0.0;  // perceptual roughness
  double mean_alpha_squared = 0.0;
};

/// Returns the facets that texel (x, y) of a level of `width` by `height` texels covers. The first plane of `material`
/// is alpha^2. If `material` is null, all texels have `alpha_squared`.
CoveredFacets covered_facets(const PlaneStore& normals, const PlaneStore* material, double alpha_squared, int width,
                             int height, int x, int y);

/// Lights of several views, and the reference under these lights.
struct ReferenceLights {
  std::vector<LightSet> views;
  std::vector<std::vector<double>> values;  // mean highlights, one list per view
  double total = 0.0;                       // integral of the reference over lights and views
  double noise = 0.0;                       // standard error of `total`, relative to `total`
};

/// Draws point lights. Three quarters of them are drawn from the distribution of visible half vectors of the facets
/// that the texel covers. One quarter is drawn from a lobe that is wider than all facets together. Different seeds give
/// different lights.
ReferenceLights point_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed);

/// Draws lights that are 20 degrees wide. Each light consists of `points` adjacent points in the list, and the share of
/// each point applies to the whole light.
ReferenceLights wide_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed);
constexpr std::size_t kWideLightPoints = 16;

/// The difference between a lobe's highlight and the reference.
struct LobeError {
  double error = 0.0;   // relative L1 error: integral of |lobe - reference| divided by the integral of the reference
  double energy = 0.0;  // integral of the lobe divided by the integral of the reference
};

/// Computes the highlight of each light of a view.
using HighlightsOf = std::function<void(const LightSet& lights, std::vector<double>& values)>;

/// Returns the error of highlights. `points` is the number of adjacent points that form one light, which is 1 or
/// kWideLightPoints.
LobeError error_of_highlights(const ReferenceLights& lights, const HighlightsOf& highlights_of, std::size_t points = 1);
LobeError error_of_lobe(const ReferenceLights& lights, const GgxLobe& lobe, std::size_t points = 1);

}  // namespace multum
