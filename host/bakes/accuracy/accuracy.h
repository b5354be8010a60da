// SPDX-License-Identifier: Apache-2.0
// Measures the error of a baked mipmap against its reference in two ways.
//
// The pixel error is stored in the file and used to choose settings (host/bakes/accuracy/footprint_error.h). Its
// reference is the BRDF times n . l of every finest normal, averaged over the pixel's footprint in double precision.
// Its model takes the texels as rounded for storage, reads them with the runtime's filter
// (host/formats/asset/tap_filter.h), and shades them with the runtime's formula (models/accuracy_model.h).
// The error is relative L1, sum |model - reference| / sum reference, over footprints and a fixed set of lights and
// views.
//
// The table of levels shows the error at texel centres, midway between texels and between levels. The reference of the
// table is the BRDF averaged over the normals that each texel covers, filtered as in the model. The table measures only
// the convolution of the BRDF f, without the factor n . l.
//
// Levels finer than the first stored level are float mips of the normal map. Each of their texels is one lobe, which is
// the mean vector of the normals that the texel covers. Between such a level and a stored level, both levels are shaded
// and mixed, as in renderers (docs/contributing/ALGORITHMS.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/accuracy/accuracy_brdf.h"
#include "host/bakes/accuracy/accuracy_points.h"
#include "host/bakes/accuracy/footprint_averages.h"
#include "host/bakes/accuracy/footprint_error.h"
#include "host/bakes/accuracy/highlight.h"
#include "host/bakes/accuracy/models/accuracy_model.h"
#include "host/bakes/accuracy/models/moment_model.h"
#include "host/bakes/accuracy/models/movmf_model.h"
#include "host/bakes/accuracy/models/sh_model.h"
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
  double error;  // relative L1 error (0.1 is 10 %); the denominator is at least 1 % of the reflection of a white
                 // diffuse surface
  // Half width of the 95 % interval of `error`. The half width is 0 if all texels were measured, at least kIntervalMin
  // if they were sampled, and kIntervalUnstated in rows of a file whose header states no interval.
  double confidence;
  std::int64_t sample_count;  // number of measured texels; 0 in rows read from a file
};
/// The smallest half width that is stated. Smaller ones would be rounded to 0, because errors have six decimal places.
constexpr double kIntervalMin = 1e-6;
constexpr double kIntervalUnstated = -1.0;

/// The finest level whose differences are averages (host/bakes/scene/scene_difference.h).
constexpr int kSummaryLevel = 2;

/// The difference between two files a and b. It consists of the sum of |a - b| and the sum of b over texel centres,
/// midpoints and points half-way to the next level.
struct LevelDifference {
  int level;
  AccuracyBrdf brdf;  // the BRDF only, without a shading method or colours
  double difference = 0.0, by_default = 0.0;
};

/// Formats an error and its interval: "7.4 +- 0.2 %".
std::string error_text(double error, double confidence);

/// The 4 lights and 12 half vectors for which all errors are measured (docs/evidence/ACCURACY.md lists them).
struct AccuracyDirections {
  std::vector<glm::dvec3> lights;        // at least one direction
  std::vector<glm::dvec3> half_vectors;  // at least one direction
  std::vector<int> half_vector_lights;   // [half vector]: index of its light; used only for footprints
};
AccuracyDirections accuracy_directions();

struct AccuracySettings {
  std::vector<double> exponents = {20.0, 100.0, 500.0};  // Blinn-Phong exponents s, 1..1e5
  std::vector<Highlight> highlights;                     // further highlights, after the exponents
  std::int64_t samples_per_level = 2048;                 // number of texels per level (see SampleSettings) for maps of
                                                         // 4096 x 4096 texels; 0 means every texel. Smaller maps use
                                                         // fewer, in proportion to their side, but at least 512.
  int footprints_per_octave = 256;                       // see footprint_count(); 0 measures no footprints
  int replicates = 1;                                    // number of random choices of footprints; their seeds are
                                                         // consecutive
  std::uint64_t seed = 1;
  bool has_level_table = true;
  int first_level = 0;  // finer levels and smaller footprints are not measured
  TapFilter filter = {};
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // wrap modes of the file
  AccuracyDirections directions = accuracy_directions();
  // True if normals are shortened according to the width of their BRDF (host/formats/image/material_maps.h). The mean
  // of their lengths is `mean_cosine`. Each normal then has its own highlight width, and the measured BRDFs are
  // "roughness" and "lambert".
  bool has_roughness = false;
  float mean_cosine = 1.0f;
  int threads = 2;
};

/// Measures a file's error. The baked rows are passed in as they are stored, and the texels that the measurement reads
/// are kept until the end. With 2048 samples per level, this takes about 50 MB for a map of any size.
class AccuracyMeter {
 public:
  virtual ~AccuracyMeter() = default;
  AccuracyMeter(const AccuracyMeter&) = delete;
  AccuracyMeter& operator=(const AccuracyMeter&) = delete;

  /// True if the measurement reads any texel of these rows. Other rows do not need to be added.
  bool needs_rows(int level, int first_row, int row_count) const;

  /// Measures the error. Call this function once, after all rows that the measurement reads have been added. If
  /// `albedo` is given, the file must have colours, and each channel is compared. Reads every normal once, or several
  /// times if millions of texels are measured. The function advances no progress units.
  std::vector<AccuracyRow> run(Device& device, const PlaneStore& normals, const PlaneStore* albedo, Progress* progress);
  /// Computes the difference between the shading of this file and the shading of `by_default`, which is made from the
  /// same map, at the same texels. Call this function before run(). If `albedo` is given, `by_default` must have
  /// colours, and Lambert is compared per channel. If this file has no colours, its shading is multiplied by the mean
  /// albedo.
  std::vector<LevelDifference> difference_from(AccuracyMeter& by_default, Device& device, const PlaneStore& normals,
                                               const PlaneStore* albedo, Progress* progress);
  /// Returns one error per BRDF, measured over all replicates. The result is valid after run() if there are footprints.
  const std::vector<FootprintError>& footprint_errors() const { return footprint_errors_; }
  /// Errors of each replicate: [replicate][BRDF].
  const std::vector<std::vector<FootprintError>>& replicate_errors() const { return replicate_errors_; }

 protected:
  /// Reads the wrap modes from `header`, and determines whether the file contains the width of a BRDF.
  AccuracyMeter(PlaneSize map, const BakedHeader& header, const AccuracySettings& settings);
  /// Returns the texels that models keep.
  const TexelSelection& texels() const { return texels_; }
  /// Measures several models of the same kind. Returns the rows of run() for each model. The reference is computed
  /// once.
  std::vector<std::vector<AccuracyRow>> measure_levels(Device& device, const PlaneStore& normals,
                                                       const std::vector<AccuracyModel*>& models) const;
  virtual AccuracyModel& model() = 0;

 private:
  const AccuracySettings settings_;
  const AccuracyPoints points_;  // points of the table of levels
  const FootprintAverages footprints_;
  const TexelSelection texels_;                 // texels that points_ and footprints_ read
  const std::vector<std::size_t> model_slots_;  // [slot of points_.texels()]: slot of the same texel in texels_
  std::vector<FootprintError> footprint_errors_;
  std::vector<std::vector<FootprintError>> replicate_errors_;
};

/// Measures files of lobes.
class MovmfMeter : public AccuracyMeter {
 public:
  /// Takes the level sizes, the lobe count and the first level from `header`. The texels of `header` are not needed.
  MovmfMeter(const MovmfMipmap& header, bool has_colours, const AccuracySettings& settings)
      : AccuracyMeter({header.width(), header.height()}, header.header, settings),
        model_(header, has_colours, texels()) {}

  /// Adds `rows.height` rows of a stored level, rounded as stored. Each row is added once, in any order, and calls must
  /// not overlap.
  void add_rows(int level, int first_row, const MovmfLevel& rows) { model_.add_rows(level, first_row, rows); }

 private:
  AccuracyModel& model() override { return model_; }
  MovmfModel model_;
};

/// Measures files of moments. Each BRDF is shaded in three ways: "toksvig", "lean" and "lean-jacobian".
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
  /// Takes the level sizes, the order and the first level from `header`. The texels of `header` are not needed.
  ShMeter(const ShMipmap& header, const AccuracySettings& settings)
      : AccuracyMeter({header.header.width, header.header.height}, header.header, settings), model_(header, texels()) {}

  void add_rows(int level, int first_row, const ShLevel& rows) { model_.add_rows(level, first_row, rows); }
  std::size_t kept_bytes() const { return model_.kept_bytes(); }

 private:
  AccuracyModel& model() override { return model_; }
  ShModel model_;
};

/// Measures several mipmaps of the same map, with equal headers. Returns the rows of each. Levels finer than
/// settings.first_level may be without texels. This takes much less time than to measure them one by one.
std::vector<std::vector<AccuracyRow>> measure_each(Device& device, const std::vector<MovmfMipmap>& mipmaps,
                                                   const PlaneStore& normals, const AccuracySettings& settings);

/// Measures a whole mipmap against a map of the same size in memory. `albedo` is null or a map of that size.
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
