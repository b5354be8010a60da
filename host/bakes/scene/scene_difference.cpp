// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/scene_difference.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/settings_search/map_mosaic.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kMosaicSide = 128, kMosaicBlock = 32, kMosaics = 3;
constexpr double kStudent = 4.303;  // Student's 95 % quantile for kMosaics - 1 degrees of freedom

// Returns directions towards the scene's distant lights above the surface, or the default lights if there are none.
// Half vectors are for views from above and at two tilts.
AccuracyDirections scene_directions(const SceneDescription& scene, std::size_t map) {
  AccuracyDirections directions = accuracy_directions();
  std::vector<glm::dvec3> lights;
  for (const SceneLight& light : scene.lights)
    if (!light.is_point && light.place.z > 0.0) lights.push_back(glm::normalize(light.place));
  if (!lights.empty()) directions.lights = lights;
  double tilt = 0.0;
  for (const SceneObject& object : scene.objects)
    if (object.map == map) tilt = std::max(tilt, object.tilt_max * std::numbers::pi / 180.0);
  directions.half_vectors.clear();
  for (const glm::dvec3& light : directions.lights) {
    directions.half_vectors.push_back(glm::normalize(light + glm::dvec3(0.0, 0.0, 1.0)));
    for (const double t : {0.4 * tilt, 0.8 * tilt})
      for (const double phi : {0.3, 2.4, 4.5})
        directions.half_vectors.push_back(
            glm::normalize(light + glm::dvec3(std::sin(t) * std::cos(phi), std::sin(t) * std::sin(phi), std::cos(t))));
  }
  return directions;
}

// Returns the bake that `multum bake` makes of the same maps by default.
BakeJob default_job(const SceneDescription& scene, const MapPlan& map) {
  const BakeJob pattern;
  BakeJob job = map.job;
  job.representation = pattern.representation;
  job.fitting = pattern.fitting;
  job.encoding = pattern.encoding;
  for (const SceneMap& one : scene.maps)
    if (one.name == map.name) {
      for (std::string BakeJob::*file : kMaterialMaps) job.*file = one.job.*file;
      job.roughness_is_gloss = one.job.roughness_is_gloss;
    }
  return job;
}

// Bakes a mosaic. During the bake, material maps that the job does not name are removed from the mosaic.
std::unique_ptr<AccuracyMeter> tried(Device& device, const BakeJob& job, BakeSource& mosaic,
                                     const AccuracySettings& accuracy, Progress* progress) {
  std::optional<PlaneStore> albedo;
  std::optional<WeightMap> weights;
  if (job.albedo.empty()) albedo.swap(mosaic.albedo);
  if (job.weights.empty()) weights.swap(mosaic.weights);
  BakeReport unused;
  std::unique_ptr<AccuracyMeter> meter = try_levels(device, job, mosaic, accuracy, unused, progress);
  if (job.albedo.empty()) albedo.swap(mosaic.albedo);
  if (job.weights.empty()) weights.swap(mosaic.weights);
  return meter;
}

struct Estimate {
  double value = 0.0, confidence = 0.0;
};

// Returns the sum of differences divided by the sum of `by_default` over all mosaics. The interval follows from the
// delta method.
Estimate ratio(const std::vector<LevelDifference>& of_mosaics) {
  double difference = 0.0, by_default = 0.0, squares = 0.0;
  for (const LevelDifference& one : of_mosaics) {
    difference += one.difference;
    by_default += one.by_default;
  }
  if (!(by_default > 0.0)) return {};
  const double value = difference / by_default;
  for (const LevelDifference& one : of_mosaics) squares += std::pow(one.difference - value * one.by_default, 2.0);
  const auto n = static_cast<double>(of_mosaics.size());
  return {value, of_mosaics.size() < 2 ? 0.0 : kStudent * std::sqrt(n / (n - 1.0) * squares) / by_default};
}

}  // namespace

std::vector<BakeSource> difference_mosaics(const BakeSource& source) {
  const PlaneStore& normals = source.map.normals;
  const bool is_whole = normals.width() <= kMosaicSide && normals.height() <= kMosaicSide;
  std::vector<BakeSource> mosaics;
  for (int k = 0; k < (is_whole ? 1 : kMosaics); ++k)
    mosaics.push_back(make_mosaic(source, {kMosaicSide, kMosaicBlock, static_cast<std::uint64_t>(k) + 1}));
  return mosaics;
}

SceneDifference measure_difference(const SceneDescription& scene, const MapPlan& map, Device& device,
                                   Progress* progress) {
  MULTUM_CHECK(map.mosaics != nullptr);
  Progress quiet = cancel_only(progress);
  std::size_t number = 0;
  while (scene.maps[number].name != map.name) ++number;
  AccuracySettings accuracy;
  accuracy.exponents = map.job.measured_exponents;
  accuracy.samples_per_level = 0;
  accuracy.footprints_per_octave = 0;
  accuracy.directions = scene_directions(scene, number);
  BakeJob by_default = default_job(scene, map);
  by_default.fitting.search_start = false;  // a search on a mosaic takes a second and usually finds the same start
  std::vector<std::vector<LevelDifference>> found;  // [mosaic][level and BRDF]
  int first = 0;
  for (BakeSource& mosaic : *map.mosaics) {
    const int coarsest = mip_level_count(mosaic.map.normals.width(), mosaic.map.normals.height()) - 1;
    first = std::min(std::max(map.first_seen, kSummaryLevel), coarsest);
    accuracy.first_level = first;
    BakeJob own = map.job;
    own.fitting.first_level = first;
    own.fitting.search_start = false;
    const auto meter = tried(device, own, mosaic, accuracy, &quiet);
    const auto other = tried(device, by_default, mosaic, accuracy, &quiet);
    // If the scene shows no colours, the colours of the default bake are ignored too.
    const bool has_colours = !own.albedo.empty() || map.mean_colours;
    found.push_back(
        meter->difference_from(*other, device, mosaic.map.normals, has_colours ? mosaic.colours() : nullptr, &quiet));
  }
  SceneDifference worst;
  std::vector<AccuracyBrdf> parts;
  for (const LevelDifference& one : found.front())
    if (std::find(parts.begin(), parts.end(), one.brdf) == parts.end()) parts.push_back(one.brdf);
  for (const AccuracyBrdf& part : parts) {
    SceneDifference here;
    here.part = part.text();
    double level_count = 0.0, half_widths = 0.0;
    for (std::size_t i = 0; i < found.front().size(); ++i) {
      const LevelDifference& shape = found.front()[i];
      if (part == AccuracyBrdf::lambert() && !map.is_diffuse) continue;
      if (shape.brdf != part || shape.level < first || !(shape.by_default > 0.0)) continue;
      std::vector<LevelDifference> of_mosaics;
      for (const auto& mosaic : found) of_mosaics.push_back(mosaic[i]);
      const Estimate level = ratio(of_mosaics);
      here.error += level.value;
      half_widths += level.confidence;
      level_count += 1.0;
      if (level.value + level.confidence < here.at_most()) continue;
      here.worst_level = shape.level;
      here.worst_error = level.value;
      here.worst_confidence = level.confidence;
    }
    if (level_count == 0.0) continue;
    here.error /= level_count;
    here.confidence = half_widths / level_count;  // levels of a mosaic are correlated, so more levels do not narrow the
                                                  // interval
    if (worst.part.empty() || here.at_most() > worst.at_most()) worst = here;
  }
  return worst;
}

}  // namespace multum
