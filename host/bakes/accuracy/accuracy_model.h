// SPDX-License-Identifier: Apache-2.0
// Models what a renderer shows of a baked file, as far as the measurement (host/bakes/accuracy/accuracy.h) needs it:
// values at points of the pyramid, filtered and shaded as the runtime does. A representation may be shaded in several
// ways; each is measured.
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

/// The lights and half vectors that points are shaded with.
struct ShadingDirections {
  std::vector<glm::dvec3> half_vectors;
  std::vector<glm::dvec3> lights;
  std::vector<Highlight> highlights;
  float mean_cosine = 0.0f;  // of a roughness map that is in the lengths of normals: of lights, divided out; 0: none is
  // Of each half vector the number of the light, in `lights`, whose cosine n . l is in its highlights; empty: in none.
  std::vector<int> half_vector_lights = {};
};

/// Model values at some points.
class PointShading {
 public:
  virtual ~PointShading() = default;
  /// [point][highlights x half vectors, then lights] into values[0 .. points x values), by the model's shading number
  /// `shading`, multiplied by the colours in `channel` unless it is -1.
  virtual void shade(const PointTaps& points, int shading, int channel, int threads, std::vector<float>& values) = 0;
};

/// Keeps what is stored of the texels that points read.
class AccuracyModel {
 public:
  virtual ~AccuracyModel() = default;
  virtual bool has_colours() const = 0;
  /// The finest level that is stored; finer ones show these averages of the map instead, which must outlive it.
  int first_level() const { return kept_.first_level(); }
  void set_map_averages(const TexelSums* averages) { map_averages_ = averages; }
  /// Names of the ways to shade it; one without a name where there is no choice.
  virtual const std::vector<std::string>& shadings() const = 0;
  /// After all texels have come. The model must outlive it.
  virtual std::unique_ptr<PointShading> make_shading(Device& device, const ShadingDirections& directions) const = 0;

 protected:
  /// `texels` must outlive it.
  AccuracyModel(const TexelSelection& texels, int first_level) : kept_(texels, first_level) {}
  /// Can points be filtered: has all come?
  bool is_complete() const { return kept_.is_complete() && (first_level() == 0 || map_averages_ != nullptr); }
  const KeptTexels& kept() const { return kept_; }
  KeptTexels& kept() { return kept_; }
  const TexelSums& map_averages() const { return *map_averages_; }

 private:
  KeptTexels kept_;
  const TexelSums* map_averages_ = nullptr;
};

/// The same directions in buffers of the device, for the shading kernels.
class DirectionBuffers {
 public:
  DirectionBuffers(Device& device, const ShadingDirections& directions);
  DirectionBuffers(const DirectionBuffers&) = delete;
  DirectionBuffers& operator=(const DirectionBuffers&) = delete;

  std::size_t value_count() const { return value_count_; }
  int half_count() const { return half_count_; }
  int light_count() const { return light_count_; }
  int highlight_count() const { return highlight_count_; }
  /// Multiplies values that were shaded as Blinn-Phong of each highlight's exponent by the integral that it has.
  void scale_by_totals(std::vector<float>& values) const;
  const DeviceBuffer& half_vectors() const { return half_buffer_; }
  const DeviceBuffer& lights() const { return light_buffer_; }
  const DeviceBuffer& highlights() const { return highlight_buffer_; }
  const DeviceBuffer& exponents() const { return exponent_buffer_; }

 private:
  std::vector<glm::vec4> half_vectors_, lights_;
  std::vector<MultumHighlight> shaded_;
  std::vector<float> exponents_;  // of each highlight
  int half_count_, light_count_, highlight_count_;
  std::size_t value_count_;
  DeviceBuffer half_buffer_, light_buffer_, highlight_buffer_, exponent_buffer_;
};

}  // namespace multum
