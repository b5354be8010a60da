// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked mipmap of lobes. Filters the lobes of the texels around a point linearly, and
// shades them on the device with the runtime's formula (kernels/movmf_shade.cl). Keeps only the lobes of texels that
// points read.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/accuracy/models/accuracy_model.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

class MovmfModel : public AccuracyModel {
 public:
  /// The program that shades models of such mipmaps on a device.
  static ProgramChoice program(const Device& device, Representation representation, int lobe_count, int first_level);

  /// `mipmap` needs no texels. `texels` must outlive the model.
  MovmfModel(const MovmfMipmap& mipmap, bool has_colours, const TexelSelection& texels);

  void add_rows(int level, int first_row, const MovmfLevel& rows);
  bool has_colours() const override { return !colours_.empty(); }
  const std::vector<std::string>& shadings() const override;
  std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const override;
  /// Returns the number of lobes per filtered point. The lobes of the file come first. If fine levels are missing, one
  /// lobe for the map's averages follows.
  std::size_t lobe_count() const { return lobe_count_ + (first_level() > 0 ? 1 : 0); }
  ProgramChoice program(const Device& device) const;

  /// Returns lobes[point][lobe], filtered as in hardware. The lobes are multiplied by their colours of channel
  /// `channel`, unless `channel` is -1.
  std::vector<glm::vec4> filtered_lobes(const PointTaps& points, int channel, int threads) const;

 private:
  void add_tap(std::size_t slot, double weight, int channel, glm::dvec4* lobes, double* colours) const;

  bool is_planar_;
  Representation representation_;
  std::size_t lobe_count_;
  std::vector<glm::vec4> lobes_;    // [kept texel][lobe]
  std::vector<glm::vec3> colours_;  // [kept texel][lobe]
};

}  // namespace multum
