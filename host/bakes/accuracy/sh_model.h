// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file of spherical harmonics: the coefficients of the texels around a point,
// filtered linearly, and shaded by the runtime's formula on the device (kernels/sh_shade.cl). Keeps the texels that
// points read, no others.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy_model.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "kernels/shared/filtered_sh.h"

namespace multum {

class ShModel : public AccuracyModel {
 public:
  /// `header` needs no texels; `texels` must outlive it.
  ShModel(const ShMipmap& header, const TexelSelection& texels);

  /// Rows of a stored level; in any order, each row once.
  void add_rows(int level, int first_row, const ShLevel& rows);

  int order() const { return order_; }
  /// Memory that the kept texels take.
  std::size_t kept_bytes() const { return coefficients_.size() * sizeof(float); }

  bool has_colours() const override { return has_colours_; }
  const std::vector<std::string>& shadings() const override;
  std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const override;

  /// Points [begin, end) as hardware filtering gives them, their coefficients [point][coefficient] apart; all is
  /// multiplied by the colours in `channel` unless it is -1, as shading is linear but for its clamp at 0.
  struct Filtered {
    std::vector<float> coefficients;
    std::vector<MultumFilteredSh> points;
  };
  Filtered filtered(const PointTaps& points, std::size_t begin, std::size_t end, int channel, int threads) const;

 private:
  struct Colour {
    double stored = 0.0, of_map = 0.0;
  };
  void add_tap(std::size_t slot, double weight, int channel, double* coefficients, double* map, double* share,
               Colour& colour) const;

  const int order_;
  const std::size_t count_;  // coefficients of a texel
  const bool has_colours_;
  std::vector<float> coefficients_;  // [kept texel][coefficient]
  std::vector<glm::vec3> colours_;
};

}  // namespace multum
