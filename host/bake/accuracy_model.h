// SPDX-License-Identifier: Apache-2.0
// What a renderer shows of a baked mipmap: the lobes of the texels around a point, filtered linearly, and shaded by the
// runtime's formula on the device (kernels/movmf_shade.cl). Keeps the lobes of the texels that points read, no others.
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/asset/movmf_mipmap.h"
#include "host/bake/accuracy_points.h"
#include "host/bake/accuracy_truth.h"
#include "host/opencl/device.h"

namespace multum {

class AccuracyModel {
 public:
  /// `mipmap` without texels; `texels` must outlive it.
  AccuracyModel(const MovmfMipmap& mipmap, bool has_colours, const TexelSelection& texels);

  void add_rows(int level, int first_row, const MovmfLevel& rows);
  /// Have all texels come?
  bool is_complete() const { return missing_count_ == 0; }
  bool has_colours() const { return !colours_.empty(); }

  /// Levels that are not stored show these averages of the map instead; must outlive it.
  void set_map_averages(const TexelSums* averages) { map_averages_ = averages; }
  int first_level() const { return first_level_; }
  /// Of filtered points: behind the lobes, one of the averages where there are any.
  std::size_t lobe_count() const { return lobe_count_ + (first_level_ > 0 ? 1 : 0); }

  /// lobes[point][lobe] as hardware filtering gives them; multiplied by their colours in `channel` unless it is -1.
  std::vector<glm::vec4> filtered_lobes(const std::vector<SamplePoint>& points, int channel, int threads) const;

 private:
  void add_tap(std::size_t slot, double weight, int channel, glm::dvec4* lobes, double* colours) const;

  const TexelSelection& texels_;
  std::size_t lobe_count_;
  int first_level_;
  std::size_t first_slot_;  // the first texel that is stored
  std::size_t missing_count_;
  std::vector<glm::vec4> lobes_;    // [slot - first_slot][lobe]
  std::vector<glm::vec3> colours_;  // the same
  const TexelSums* map_averages_ = nullptr;
};

/// The lights and half vectors that points are shaded with.
struct ShadingDirections {
  std::vector<glm::dvec3> half_vectors;
  std::vector<glm::dvec3> lights;
  std::vector<double> exponents;
};

/// Model values at some points.
class PointShading {
 public:
  PointShading(Device& device, const AccuracyModel& model, const ShadingDirections& directions);
  /// [point][exponents x half vectors, then lights]
  std::size_t value_count() const { return value_count_; }
  /// Into values[0 .. points x values).
  void shade(const std::vector<SamplePoint>& points, int channel, int threads, std::vector<float>& values);

 private:
  Device& device_;
  const AccuracyModel& model_;
  std::vector<glm::vec4> half_vectors_, lights_;
  std::vector<float> exponents_;
  int half_count_, light_count_, exponent_count_;
  std::size_t value_count_;
  DeviceBuffer half_buffer_, light_buffer_, exponent_buffer_, value_buffer_;
  Kernel kernel_;
};

}  // namespace multum
