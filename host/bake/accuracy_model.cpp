// SPDX-License-Identifier: Apache-2.0
#include "host/bake/accuracy_model.h"

namespace multum {
namespace {

// Never empty: a buffer is not.
std::vector<glm::vec4> padded(const std::vector<glm::dvec3>& directions, float w) {
  std::vector<glm::vec4> result;
  for (const glm::dvec3& direction : directions) result.emplace_back(glm::vec3(direction), w);
  if (result.empty()) result.emplace_back(0.0f);
  return result;
}

}  // namespace

DirectionBuffers::DirectionBuffers(Device& device, const ShadingDirections& directions)
    : half_vectors_(padded(directions.half_vectors, 0.0f)),
      lights_(padded(directions.lights, directions.mean_cosine)),
      exponents_(directions.exponents.begin(), directions.exponents.end()),
      half_count_(static_cast<int>(directions.half_vectors.size())),
      light_count_(static_cast<int>(directions.lights.size())),
      exponent_count_(static_cast<int>(directions.exponents.size())),
      value_count_(directions.half_vectors.size() * exponents_.size() + directions.lights.size()) {
  if (exponents_.empty()) exponents_.push_back(1.0f);
  half_buffer_ = device.wrap_buffer(half_vectors_.data(), half_vectors_.size() * sizeof(glm::vec4), "half vectors");
  light_buffer_ = device.wrap_buffer(lights_.data(), lights_.size() * sizeof(glm::vec4), "lights");
  exponent_buffer_ = device.wrap_buffer(exponents_.data(), exponents_.size() * sizeof(float), "exponents");
}

}  // namespace multum
