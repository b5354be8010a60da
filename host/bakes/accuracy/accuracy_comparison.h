// SPDX-License-Identifier: Apache-2.0
// Compares models with references at all points and footprints of a measurement.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/accuracy_reference.h"
#include "host/bakes/accuracy/error_sums.h"

namespace multum {

FootprintSettings footprint_settings(const AccuracySettings& settings);
/// Returns the highlights of the exponents, then the further ones.
std::vector<Highlight> highlights_of(const AccuracySettings& settings);
/// Adds a point, whose texels are in `model_slots`.
void append_taps(const SamplePoint& point, const std::vector<std::size_t>& model_slots, PointTaps& taps);

/// The texels and footprints that a measurement reads.
struct MeasuredPlaces {
  const AccuracyPoints& points;
  const FootprintAverages& footprints;
  const TexelSelection& model_texels;
  const std::vector<std::size_t>& model_slots;  // the slots of the texels that points read
};

/// One measurement of one or several models of the same kind. Each pass evaluates the reference for as many directions
/// as fit into memory, and compares the reference with the models. There are few footprints, so the first pass handles
/// all of them.
class AccuracyComparison {
 public:
  AccuracyComparison(const AccuracySettings& settings, const MeasuredPlaces& places, std::vector<AccuracyModel*> models,
                     bool has_colours);

  void run(Device& device, const FinestPlanes& planes, Progress* progress);

  std::vector<AccuracyRow> rows(std::size_t model) const;

  /// Measures one part of the footprints, which are split into `count` equal, consecutive parts.
  std::vector<FootprintError> footprint_errors(std::size_t model, int part, int count) const;

 private:
  // `directions` and `references` hold half vectors first, then lights.
  struct Pass {
    ShadingDirections directions;
    std::vector<std::unique_ptr<BrdfReference>> references;
  };

  bool has_footprints() const { return !places_.footprints.footprints().empty(); }
  std::size_t direction_count() const { return half_count() + settings_.directions.lights.size(); }
  std::size_t half_count() const { return highlights_.empty() ? 0 : settings_.directions.half_vectors.size(); }

  // If the values of all directions do not fit into memory, another pass over the map is made. With 2048 samples per
  // level, the 40 values of all directions need 33 MB for a map of 16384 x 16384 texels, or four times as much with
  // colours. If every texel of a map of 1024 x 1024 texels is measured, three values need 34 MB. The result does not
  // depend on the number of threads, because sums are added pass by pass.
  Pass next_pass(std::size_t first) const;

  BrdfValues brdf_values(const glm::dvec3& omega, bool is_light) const;

  // References for half vectors first, then for lights.
  std::vector<std::unique_ptr<FootprintReference>> make_footprint_references() const;

  // Fills footprint_sums_[model][BRDF][footprint].
  void compare_footprints(Device& device, const std::vector<std::unique_ptr<FootprintReference>>& references,
                          std::size_t model);

  // Adds the errors of one colour channel to sums_of[highlights, then Lambert]. The channel is -1 if there are no
  // colours.
  void add_footprints(const std::vector<std::unique_ptr<FootprintReference>>& references,
                      const std::vector<std::size_t>& point_begin, const std::vector<float>& values, int channel,
                      std::vector<ErrorSum>* sums_of) const;

  // Returns the factor by which the averages of the reference must still be multiplied.
  double value_scale(bool is_light, std::size_t highlight) const;

  void compare(Device& device, const Pass& pass, bool is_first, Progress* progress);

  // Returns the reference of each point for one colour channel, [value][point], in the order of the model's values. The
  // channel is -1 if there are no colours.
  std::vector<double> references_at(const Pass& pass, const std::vector<SamplePoint>& points, int channel) const;

  // Adds the differences of points to BRDFs first_brdf + (highlights, then Lambert).
  void compare_points(const Pass& pass, const std::vector<SamplePoint>& points, const std::vector<float>& values,
                      const std::vector<double>& references, std::size_t first_brdf, ErrorSums& sums) const;

  static double reference_at(const TexelSums& reference, const SamplePoint& point, std::size_t value);

  // There is one group without colours and, if the file has colours, one group with colours.
  std::size_t groups_per_shading() const { return channel_count_ > 0 ? 2 : 1; }
  std::size_t brdf_count() const { return plain_count_ * groups_per_shading() * shadings_.size(); }
  AccuracyBrdf what_of(std::size_t brdf) const;

  const AccuracySettings& settings_;
  const MeasuredPlaces places_;
  const AccuracyPoints& points_;
  const std::vector<AccuracyModel*> models_;
  const std::vector<Highlight> highlights_;
  const std::vector<std::string> shadings_;
  const std::size_t channel_count_;  // 0 if there are no colours
  const std::size_t plain_count_;    // number of BRDFs: highlights, then Lambert
  const TexelAverages averages_;
  std::vector<ErrorSums> sums_;                                     // [model]
  std::vector<std::vector<std::vector<ErrorSum>>> footprint_sums_;  // [model][BRDF][footprint]
};

}  // namespace multum
