// SPDX-License-Identifier: Apache-2.0
// Measures how far a baked mipmap is from its reference, in two ways.
//
// What a bake states, promises and is chosen by is the error of pixels (host/bakes/accuracy/footprint_error.h).
// Reference: the average, over the pixel's footprint, of the BRDF times n . l of every finest normal, in double. Model:
// what is stored, rounded as stored, read by the runtime's filter (host/formats/asset/tap_filter.h), filtered and
// shaded by the runtime's formula (accuracy_model.h). Error: relative L1 = sum |model - reference| / sum reference,
// over footprints and a fixed set of lights and views.
//
// The table of levels says where a fit is good: at texel centres, midway between texels and between levels, against
// averages over the normals that the texels cover, filtered alike, of the BRDF's convolution alone, f without n . l.
//
// Levels finer than the first that is stored are the normal map's own mips, in float, each texel one lobe with the mean
// vector of the normals that it covers; between them and the stored levels both are shaded and mixed, as renderers do
// (docs/contributing/ALGORITHMS.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/bakes/accuracy/accuracy_model.h"
#include "host/bakes/accuracy/accuracy_points.h"
#include "host/bakes/accuracy/footprint_averages.h"
#include "host/bakes/accuracy/footprint_error.h"
#include "host/bakes/accuracy/highlight.h"
#include "host/bakes/accuracy/moment_model.h"
#include "host/bakes/accuracy/movmf_model.h"
#include "host/bakes/accuracy/sh_model.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct AccuracyRow {
  int level;
  AccuracyPoint point;
  AccuracyBrdf brdf;
  double error;  // relative L1, 0.1 = 10 %; of a hundredth of a white diffuse surface where the reference is less
  // Half width of the 95 % interval of `error`: 0 where all texels were measured, at least kIntervalMin where they were
  // sampled, kIntervalUnstated in rows of a file whose header has none.
  double confidence;
  std::int64_t sample_count;  // texels; 0 in rows of a file
};
/// Errors are stated to the sixth digit behind the point: a narrower interval would be none of what is stated.
constexpr double kIntervalMin = 1e-6;
constexpr double kIntervalUnstated = -1.0;

/// The finest level of which differences are an average (host/bakes/scene/scene_difference.h).
constexpr int kSummaryLevel = 2;

/// Difference between two files over texel centres, midpoints, and half-way to the next level: sums of |a - b| and of
/// b.
struct LevelDifference {
  int level;
  AccuracyBrdf brdf;  // however shaded, without colours
  double difference = 0.0, by_default = 0.0;
};

/// "7.4 +- 0.2 %".
std::string error_text(double error, double confidence);

/// The lights and half vectors of every figure: 4 lights, 12 half vectors (docs/evidence/ACCURACY.md names them).
struct AccuracyDirections {
  std::vector<glm::dvec3> lights;        // at least one
  std::vector<glm::dvec3> half_vectors;  // at least one
  std::vector<int> half_vector_lights;   // [half vector]: the number of its light; of footprints alone, which need them
};
AccuracyDirections accuracy_directions();

struct AccuracySettings {
  std::vector<double> exponents = {20.0, 100.0, 500.0};  // Blinn-Phong s, 1..1e5
  std::vector<Highlight> highlights;                     // more of them, after those
  std::int64_t samples_per_level = 2048;                 // texels, see SampleSettings; 0: every texel
  int footprints_per_octave = 256;                       // 0: none
  int replicates = 1;  // so many independent choices of these, of seeds that follow each other
  std::uint64_t seed = 1;
  bool has_level_table = true;
  int first_level = 0;  // finer ones, and smaller footprints, are not measured
  TapFilter filter = {};
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // of the file
  AccuracyDirections directions = accuracy_directions();
  // Normals are shortened by their BRDF's width (host/formats/image/material_maps.h), by `mean_cosine` in the mean, and
  // every one has its own highlight: the BRDFs are "roughness" and "lambert".
  bool has_roughness = false;
  float mean_cosine = 1.0f;
  int threads = 2;
};

/// Measures a file's error: takes what a bake stores, row by row, keeps what is stored of the texels that it looks at,
/// and measures at the end. With 2048 samples a level that takes some 50 MB for maps of any size.
class AccuracyMeter {
 public:
  virtual ~AccuracyMeter() = default;
  AccuracyMeter(const AccuracyMeter&) = delete;
  AccuracyMeter& operator=(const AccuracyMeter&) = delete;

  /// Is any texel of these rows looked at? If not, they need not be added.
  bool needs_rows(int level, int first_row, int row_count) const;

  /// After all rows that it needs, once. With `albedo`, which needs a file with colours, those are compared too, per
  /// channel. Reads every normal once, more often where it looks at millions of texels. Progress: counts no units.
  std::vector<AccuracyRow> run(Device& device, const PlaneStore& normals, const PlaneStore* albedo, Progress* progress);
  /// Difference of what it shows from what `by_default` shows, of the same map at the same texels, before run(). With
  /// `albedo`, which needs a `by_default` of colours, Lambert is per channel; a file without colours then shows the
  /// albedo's mean.
  std::vector<LevelDifference> difference_from(AccuracyMeter& by_default, Device& device, const PlaneStore& normals,
                                               const PlaneStore* albedo, Progress* progress);
  /// After run(), with footprints: one for each of its BRDFs, of all replicates together.
  const std::vector<FootprintError>& footprint_errors() const { return footprint_errors_; }
  /// [replicate][BRDF].
  const std::vector<std::vector<FootprintError>>& replicate_errors() const { return replicate_errors_; }

 protected:
  /// Takes from `header` wrap modes and whether a BRDF's width is in.
  AccuracyMeter(PlaneSize map, const BakedHeader& header, const AccuracySettings& settings);
  /// That models keep.
  const TexelSelection& texels() const { return texels_; }
  virtual AccuracyModel& model() = 0;

 private:
  const AccuracySettings settings_;
  const AccuracyPoints points_;  // of the table
  const FootprintAverages footprints_;
  const TexelSelection texels_;                 // that either reads
  const std::vector<std::size_t> model_slots_;  // [slot of points_.texels()]: its slot in texels_
  std::vector<FootprintError> footprint_errors_;
  std::vector<std::vector<FootprintError>> replicate_errors_;
};

/// Measures files of lobes.
class MovmfMeter : public AccuracyMeter {
 public:
  /// Takes from `header` the sizes of levels, the lobe count and the first level; it needs no texels.
  MovmfMeter(const MovmfMipmap& header, bool has_colours, const AccuracySettings& settings)
      : AccuracyMeter({header.width(), header.height()}, header.header, settings),
        model_(header, has_colours, texels()) {}

  /// `rows.height` rows of a level that is stored, rounded as stored; in any order, each row once, one call at a time.
  void add_rows(int level, int first_row, const MovmfLevel& rows) { model_.add_rows(level, first_row, rows); }

 private:
  AccuracyModel& model() override { return model_; }
  MovmfModel model_;
};

/// Measures files of moments: each BRDF shaded as "toksvig", "lean" and "lean-jacobian".
class MomentMeter : public AccuracyMeter {
 public:
  MomentMeter(const BakedHeader& header, const AccuracySettings& settings)
      : AccuracyMeter({header.width, header.height}, header, settings), model_(header, texels()) {}

  void add_rows(int level, int first_row, const MomentLevel& rows) { model_.add_rows(level, first_row, rows); }

 private:
  AccuracyModel& model() override { return model_; }
  MomentModel model_;
};

/// Measures files of spherical harmonics.
class ShMeter : public AccuracyMeter {
 public:
  /// Takes from `header` the sizes of levels, the order and the first level; it needs no texels.
  ShMeter(const ShMipmap& header, const AccuracySettings& settings)
      : AccuracyMeter({header.header.width, header.header.height}, header.header, settings), model_(header, texels()) {}

  void add_rows(int level, int first_row, const ShLevel& rows) { model_.add_rows(level, first_row, rows); }
  std::size_t kept_bytes() const { return model_.kept_bytes(); }

 private:
  AccuracyModel& model() override { return model_; }
  ShModel model_;
};

/// Measures a whole mipmap against a map in memory, which must be of one size. `albedo`: null, or of that size.
std::vector<AccuracyRow> measure_accuracy(Device& device, const MovmfMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress);
std::vector<AccuracyRow> measure_accuracy(Device& device, const MomentMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress);
std::vector<AccuracyRow> measure_accuracy(Device& device, const ShMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress);
inline std::vector<AccuracyRow> measure_accuracy(Device& device, const MovmfMipmap& mipmap, const NormalMap& map,
                                                 const AccuracySettings& settings, Progress* progress) {
  return measure_accuracy(device, mipmap, map, nullptr, settings, progress);
}

}  // namespace multum
