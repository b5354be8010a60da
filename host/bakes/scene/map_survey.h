// SPDX-License-Identifier: Apache-2.0
// Surveys a map for a plan in one pass over its rows: moments of the normals under every texel of every level, and the
// normals themselves under a few texels of each. No device is asked.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/movmf/normal_mixture.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/plane_store.h"

namespace multum {

/// Of all texels of a level (of maps above 4 million texels, of every fourth row of level 5 and what is in it), which
/// for this purpose share out the finest ones whole: where the map's sides are no
/// powers of two, a texel on a border counts for one side alone.
struct LevelStatistics {
  int level = 0;
  double texel_count = 0.0;
  // 1 - |mean normal| of the normals under a texel: half the sum of the slopes' variances along both axes.
  double spread_mean = 0.0, spread_max = 0.0;
  // (a - b) / (a + b) of the variances along the two main axes of a texel's normals, weighted by a + b: 0 for as much
  // each way, 1 for parallel grooves.
  double anisotropy = 0.0;
};

struct SurveyedTexel {
  int level = 0;
  Normals normals;                  // all that it covers, or a part of them at random
  std::vector<glm::dvec3> colours;  // as many, linear RGB; empty: the map has none
  std::vector<glm::dvec4> weights;  // as many, of basis BRDFs; empty: the map has none
};

struct MapSurvey {
  int width = 0, height = 0;
  std::vector<LevelStatistics> levels;  // from level 1 on
  std::vector<SurveyedTexel> texels;    // level by level, from level 1 on
  double normal_range = 0.0;            // the largest difference of x or of y between two normals of the map
  double colour_range = 0.0;            // the same of red, green or blue
  double z_min = 0.0;                   // of all normals
};

struct SurveySettings {
  int texels_per_level = 32;
  int normals_per_texel = 256;
  std::uint64_t seed = 1;
  int threads = 1;
};

/// What goes along with the normals: null, or of their size.
struct SurveyedFeatures {
  const PlaneStore* albedo = nullptr;
  const WeightMap* weights = nullptr;
};

/// Normals may be shortened by a roughness.
MapSurvey survey_map(const PlaneStore& normals, const SurveyedFeatures& features, const SurveySettings& settings);

}  // namespace multum
