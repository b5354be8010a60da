// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file of moments. Filters the moments of the texels around a point linearly,
// and shades them on the device with the runtime's formulas (kernels/moment_shade.cl). Keeps only the texels that
// points read.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/bakes/accuracy/models/accuracy_model.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "kernels/shared/moments.h"

namespace multum {

class MomentModel : public AccuracyModel {
 public:
  /// `texels` must outlive the model.
  MomentModel(const BakedHeader& header, const TexelSelection& texels);

  /// Adds rows of a stored level. Each row is added once, in any order.
  void add_rows(int level, int first_row, const MomentLevel& rows);

  bool has_colours() const override { return has_colours_; }
  const std::vector<std::string>& shadings() const override;
  std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const override;

  /// Returns moments at points, filtered as in hardware. Their share is multiplied by the colours of channel `channel`,
  /// unless `channel` is -1. This suffices because shading is linear in the share. At points between a stored level and
  /// a level of the normal map, each of the two levels has its own colour.
  std::vector<MultumFilteredMoments> filtered(const PointTaps& points, int channel, int threads) const;

 private:
  void add_tap(std::size_t slot, double weight, int channel, double* sums) const;

  const bool has_colours_;
  std::vector<SlopeMoments> slopes_;  // [kept texel]
  std::vector<glm::vec3> normals_, colours_;
};

}  // namespace multum
