// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/models/accuracy_model.h"

namespace multum {
namespace {

// The result has at least one element, because a buffer cannot be empty.
std::vector<glm::vec4> padded(const std::vector<glm::dvec3>& directions, float w) {
  std::vector<glm::vec4> result;
  for (const glm::dvec3& direction : directions) result.emplace_back(glm::vec3(direction), w);
  if (result.empty()) result.emplace_back(0.0f);
  return result;
}

}  // namespace

void order_by_value(const std::vector<float>& values, std::size_t value_count, std::size_t first,
                    std::size_t all_points, std::vector<float>& to) {
  for (std::size_t i = 0; i < values.size() / value_count; ++i)
    for (std::size_t v = 0; v < value_count; ++v) to[v * all_points + first + i] = values[i * value_count + v];
}

DirectionBuffers::DirectionBuffers(Device& device, const ShadingDirections& directions)
    : half_vectors_(padded(directions.half_vectors, 0.0f)),
      lights_(padded(directions.lights, directions.mean_cosine)),
      half_count_(static_cast<int>(directions.half_vectors.size())),
      light_count_(static_cast<int>(directions.lights.size())),
      highlight_count_(static_cast<int>(directions.highlights.size())),
      value_count_(directions.half_vectors.size() * directions.highlights.size() + directions.lights.size()) {
  for (std::size_t d = 0; d < directions.half_vector_lights.size(); ++d)
    half_vectors_[d].w = 1.0f + static_cast<float>(directions.half_vector_lights[d]);
  for (const Highlight& highlight : directions.highlights) shaded_.push_back(highlight.shaded);
  if (shaded_.empty()) shaded_.push_back(shaded_highlight(1.0));
  for (const MultumHighlight& highlight : shaded_) exponents_.push_back(highlight.exponent);
  half_buffer_ = device.wrap_buffer(half_vectors_.data(), half_vectors_.size() * sizeof(glm::vec4), "half vectors");
  light_buffer_ = device.wrap_buffer(lights_.data(), lights_.size() * sizeof(glm::vec4), "lights");
  highlight_buffer_ = device.wrap_buffer(shaded_.data(), shaded_.size() * sizeof(MultumHighlight), "highlights");
  exponent_buffer_ = device.wrap_buffer(exponents_.data(), exponents_.size() * sizeof(float), "exponents");
}

void DirectionBuffers::scale_by_totals(std::vector<float>& values) const {
  const std::size_t of_highlight = static_cast<std::size_t>(half_count_) * (values.size() / value_count_);
  for (std::size_t f = 0; f < static_cast<std::size_t>(highlight_count_); ++f) {
    if (shaded_[f].total == 1.0f) continue;
    for (std::size_t i = f * of_highlight; i < (f + 1) * of_highlight; ++i) values[i] *= shaded_[f].total;
  }
}

}  // namespace multum
