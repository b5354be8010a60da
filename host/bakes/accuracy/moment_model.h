// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file of moments: the moments of the texels around a point, filtered linearly,
// and shaded by the runtime's formulas on the device (kernels/moment_shade.cl). Keeps the texels that points read, no
// others.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy_model.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "kernels/shared/moments.h"

namespace multum {

class MomentModel : public AccuracyModel {
 public:
  /// `texels` must outlive it.
  MomentModel(const BakedHeader& header, const TexelSelection& texels);

  /// Rows of a stored level; in any order, each row once.
  void add_rows(int level, int first_row, const MomentLevel& rows);

  bool has_colours() const override { return has_colours_; }
  const std::vector<std::string>& shadings() const override;
  std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const override;

  /// Moments at points as hardware filtering gives them; multiplied by the colours in `channel` unless it is -1, as a
  /// share is: shading is linear in the share, and of points between a stored level and one of the normal map's each
  /// side has its own colour.
  std::vector<MultumFilteredMoments> filtered(const PointTaps& points, int channel, int threads) const;

 private:
  void add_tap(std::size_t slot, double weight, int channel, double* sums) const;

  const bool has_colours_;
  std::vector<SlopeMoments> slopes_;  // [kept texel]
  std::vector<glm::vec3> normals_, colours_;
};

}  // namespace multum
