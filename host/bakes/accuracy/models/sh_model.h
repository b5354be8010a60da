// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file of spherical harmonics. Filters the coefficients of the texels around a
// point linearly, and shades them on the device with the runtime's formula (kernels/sh_shade.cl). Keeps only the texels
// that points read.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/bakes/accuracy/models/accuracy_model.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "kernels/shared/filtered_sh.h"

namespace multum {

class ShModel : public AccuracyModel {
 public:
  /// `header` needs no texels. `texels` must outlive the model.
  ShModel(const ShMipmap& header, const TexelSelection& texels);

  /// Adds rows of a stored level. Each row is added once, in any order.
  void add_rows(int level, int first_row, const ShLevel& rows);

  int order() const { return order_; }
  /// Returns the memory that the kept texels need.
  std::size_t kept_bytes() const { return coefficients_.size() * sizeof(float); }

  bool has_colours() const override { return has_colours_; }
  const std::vector<std::string>& shadings() const override;
  std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const override;

  /// Returns points [begin, end), filtered as in hardware. Their coefficients are stored separately, as
  /// [point][coefficient]. Points and coefficients are multiplied by the colours of channel `channel`, unless `channel`
  /// is -1. This is possible because shading is linear except for the clamp at 0.
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
  const std::size_t count_;  // coefficients per texel
  const bool has_colours_;
  std::vector<float> coefficients_;  // [kept texel][coefficient]
  std::vector<glm::vec3> colours_;
};

}  // namespace multum
