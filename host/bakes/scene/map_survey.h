// SPDX-License-Identifier: Apache-2.0
// Surveys a map for a plan in one pass over its rows. Collects the moments of the normals that each texel of each level
// covers, and the normals themselves for a few texels of each level. No device is needed.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/movmf/normal_mixture.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/plane_store.h"

namespace multum {

/// Statistics over all texels of a level. On maps of more than 4 million texels, they use only every fourth row of
/// level 5 and the finer texels in these rows. Each texel of the finest level belongs to one texel of the coarser
/// level. If the map's sides are not powers of two, a finest texel can be on the border between two coarser texels. It
/// then counts for only one of them.
struct LevelStatistics {
  int level = 0;
  double texel_count = 0.0;
  // 1 - |mean normal| of the normals that a texel covers. For small slopes, this value is half the sum of the variances
  // of the slopes along both axes.
  double spread_mean = 0.0, spread_max = 0.0;
  // (a - b) / (a + b), weighted by a + b, where a and b are the variances along the two main axes of a texel's normals.
  // The value is 0 for equal spread and 1 for parallel grooves.
  double anisotropy = 0.0;
};

struct SurveyedTexel {
  int level = 0;
  Normals normals;                  // all normals that the texel covers, or a random selection of them
  std::vector<glm::dvec3> colours;  // [normal], linear RGB; empty if the map has no colours
  std::vector<glm::dvec4> weights;  // [normal], weights of basis BRDFs; empty if the map has none
};

struct MapSurvey {
  int width = 0, height = 0;
  std::vector<LevelStatistics> levels;  // from level 1 on
  std::vector<SurveyedTexel> texels;    // surveyed texels by level, from level 1 on
  double normal_range = 0.0;            // the largest difference in x or in y between two normals of the map
  double colour_range = 0.0;            // the largest difference in red, green or blue
  double z_min = 0.0;                   // the smallest z of all normals
};

struct SurveySettings {
  int texels_per_level = 32;
  int normals_per_texel = 256;
  std::uint64_t seed = 1;
  int threads = 1;
};

/// The features of the same texels, which are null or have the map's size.
struct SurveyedFeatures {
  const PlaneStore* albedo = nullptr;
  const WeightMap* weights = nullptr;
};

/// Normals may be shortened according to roughness.
MapSurvey survey_map(const PlaneStore& normals, const SurveyedFeatures& features, const SurveySettings& settings);

}  // namespace multum
