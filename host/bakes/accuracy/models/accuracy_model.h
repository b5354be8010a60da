// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file, for the measurement in host/bakes/accuracy/accuracy.h. Computes values
// at points of the pyramid by filtering and shading as the runtime does. If a representation has several shading
// methods, each is measured.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/bakes/accuracy/accuracy_reference.h"
#include "host/bakes/accuracy/highlight.h"
#include "host/bakes/accuracy/kept_texels.h"
#include "host/bakes/accuracy/point_taps.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// Lights and half vectors for shading points.
struct ShadingDirections {
  std::vector<glm::dvec3> half_vectors;
  std::vector<glm::dvec3> lights;
  std::vector<Highlight> highlights;
  float mean_cosine = 0.0f;  // the mean cosine of a baked roughness map, by which lights are divided; 0 if there is no
                             // such map
  // [half vector]: index in `lights` of the light whose cosine n . l multiplies the highlights. Empty if highlights are
  // not multiplied by a cosine.
  std::vector<int> half_vector_lights = {};
};

/// Copies values [point][value] to `to`, which holds [value][all_points], from point `first` on.
void order_by_value(const std::vector<float>& values, std::size_t value_count, std::size_t first,
                    std::size_t all_points, std::vector<float>& to);

/// Evaluates the model at points.
class PointShading {
 public:
  virtual ~PointShading() = default;
  /// Writes [highlights x half vectors, then lights][point] to values[0 .. values x points). `shading` is the number of
  /// one of the model's shadings. Values are multiplied by the colours of channel `channel`, unless `channel` is -1.
  virtual void shade(const PointTaps& points, int shading, int channel, int threads, std::vector<float>& values) = 0;
};

/// Keeps the stored texels that points read.
class AccuracyModel {
 public:
  virtual ~AccuracyModel() = default;
  virtual bool has_colours() const = 0;
  /// The finest stored level. Finer levels show the map averages that were passed to set_map_averages(). These averages
  /// must outlive the model.
  int first_level() const { return kept_.first_level(); }
  void set_map_averages(const TexelSums* averages) { map_averages_ = averages; }
  /// Returns the names of the shading methods. If there is only one method, its name is empty.
  virtual const std::vector<std::string>& shadings() const = 0;
  /// Call this function after all texels have been added. The model must outlive the result.
  virtual std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const = 0;

 protected:
  /// `texels` must outlive the model.
  AccuracyModel(const TexelSelection& texels, int first_level) : kept_(texels, first_level) {}
  /// True if all texels have been added, so that points can be filtered.
  bool is_complete() const { return kept_.is_complete() && (first_level() == 0 || map_averages_ != nullptr); }
  const KeptTexels& kept() const { return kept_; }
  KeptTexels& kept() { return kept_; }
  const TexelSums& map_averages() const { return *map_averages_; }

 private:
  KeptTexels kept_;
  const TexelSums* map_averages_ = nullptr;
};

/// Directions and highlights in device buffers, for the shading kernels.
class DirectionBuffers {
 public:
  DirectionBuffers(Device& device, const ShadingDirections& directions);
  DirectionBuffers(const DirectionBuffers&) = delete;
  DirectionBuffers& operator=(const DirectionBuffers&) = delete;

  std::size_t value_count() const { return value_count_; }
  int half_count() const { return half_count_; }
  int light_count() const { return light_count_; }
  int highlight_count() const { return highlight_count_; }
  /// Multiplies values [value][point] by the integral of the highlight. The values must have been shaded as Blinn-Phong
  /// with the highlight's exponent.
  void scale_by_totals(std::vector<float>& values) const;
  const DeviceBuffer& half_vectors() const { return half_buffer_; }
  const DeviceBuffer& lights() const { return light_buffer_; }
  const DeviceBuffer& highlights() const { return highlight_buffer_; }
  const DeviceBuffer& exponents() const { return exponent_buffer_; }

 private:
  std::vector<glm::vec4> half_vectors_, lights_;
  std::vector<MultumHighlight> shaded_;
  std::vector<float> exponents_;  // [highlight]
  int half_count_, light_count_, highlight_count_;
  std::size_t value_count_;
  DeviceBuffer half_buffer_, light_buffer_, highlight_buffer_, exponent_buffer_;
};

}  // namespace multum
