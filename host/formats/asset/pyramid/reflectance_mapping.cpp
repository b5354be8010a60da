// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/pyramid/reflectance_mapping.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

nlohmann::json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

glm::dvec3 vector_of(const nlohmann::json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace

ReflectanceFrame reflectance_frame(const glm::dvec3& viewer, const glm::dvec3& up) {
  MULTUM_CHECK(glm::length(viewer) > 0.0);
  ReflectanceFrame frame;
  frame.viewer = glm::normalize(viewer);
  glm::dvec3 right = glm::cross(up, frame.viewer);
  if (glm::length(right) < 1e-6 * glm::length(up) || glm::length(up) == 0.0)
    right = glm::cross(std::abs(frame.viewer.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(0.0, 1.0, 0.0),
                       frame.viewer);
  frame.right = glm::normalize(right);
  frame.up = glm::cross(frame.viewer, frame.right);
  return frame;
}

glm::dvec2 reflectance_place(const ReflectanceFrame& frame, const glm::dvec3& normal) {
  const double x = glm::dot(normal, frame.right), y = glm::dot(normal, frame.up), z = glm::dot(normal, frame.viewer);
  // Computes sqrt(2 / (1 + z)). On the back side, where 1 + z loses digits, uses 1 + z = (x^2 + y^2) / (1 - z).
  const double flat = std::hypot(x, y);
  const double one_plus_z = z > 0.0 ? 1.0 + z : flat * flat / (1.0 - z);
  if (one_plus_z <= 0.0) return {0.0, 0.0};
  const double scale = std::sqrt(2.0 / one_plus_z) / kReflectanceSide;
  return {0.5 + x * scale, 0.5 - y * scale};
}

glm::dvec3 reflectance_normal(const ReflectanceFrame& frame, const glm::dvec2& place) {
  const double px = (place.x - 0.5) * kReflectanceSide, py = (0.5 - place.y) * kReflectanceSide;
  const double square = std::min(px * px + py * py, 4.0);
  const double flat = std::sqrt(1.0 - 0.25 * square);
  return glm::normalize(px * flat * frame.right + py * flat * frame.up + (1.0 - 0.5 * square) * frame.viewer);
}

std::string reflectance_frame_json(const ReflectanceFrame& frame) {
  return nlohmann::json{{"right", json_of(frame.right)}, {"up", json_of(frame.up)}, {"viewer", json_of(frame.viewer)}}
      .dump();
}

ReflectanceFrame parse_reflectance_frame(const std::string& settings, const std::string& path) {
  const nlohmann::json json = nlohmann::json::parse(settings, nullptr, false);
  try {
    const nlohmann::json& frame = json.at("frame");
    ReflectanceFrame found{vector_of(frame.at("right")), vector_of(frame.at("up")), vector_of(frame.at("viewer"))};
    for (const glm::dvec3& axis : {found.right, found.up, found.viewer})
      if (!(std::abs(glm::length(axis) - 1.0) < 1e-6)) throw std::runtime_error("");
    return found;
  } catch (const std::exception&) {
    throw Error(
        ErrorCode::kInput,
        path + ": its settings contain no frame of three unit vectors, expected the settings of `multum reflectance`");
  }
}

}  // namespace multum
