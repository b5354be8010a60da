// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/texture_mapping.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

WrapMode wrap_from(const nlohmann::json& json) {
  const std::string name = json.get<std::string>();
  const std::optional<WrapMode> mode = parse_wrap_mode(name);
  if (!mode || (*mode != WrapMode::kClamp && *mode != WrapMode::kPeriodic))
    throw Error(ErrorCode::kInput, "the wrap mode of a texture mapping is '" + name + "', expected clamp or periodic");
  return *mode;
}

}  // namespace

glm::dvec2 cut_shift(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices, std::size_t triangle,
                     const TextureMapping& mapping) {
  glm::dvec2 shift(0.0);
  for (std::size_t d = 0; d < 2; ++d) {
    if (!mapping.has_cut[d]) continue;
    const auto axis = static_cast<glm::length_t>(d);
    double low = static_cast<double>(uvs[indices[3 * triangle]][axis]), high = low;
    for (std::size_t k = 1; k < 3; ++k) {
      const double value = static_cast<double>(uvs[indices[3 * triangle + k]][axis]);
      low = std::min(low, value);
      high = std::max(high, value);
    }
    shift[axis] = -std::floor(0.5 * (low + high) - mapping.cut[d]);
  }
  return shift;
}

std::vector<glm::vec2> mapped_corners(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices,
                                      const TextureMapping& mapping) {
  std::vector<glm::vec2> corners;
  corners.reserve(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i)
    corners.emplace_back(mapping.linear * (glm::dvec2(uvs[indices[i]]) + cut_shift(uvs, indices, i / 3, mapping)) +
                         mapping.offset);
  return corners;
}

void to_json(nlohmann::json& json, const TextureMapping& m) {
  json = {{"linear", {m.linear[0][0], m.linear[1][0], m.linear[0][1], m.linear[1][1]}},
          {"offset", {m.offset.x, m.offset.y}},
          {"hasCut", m.has_cut},
          {"cut", m.cut},
          {"wrapS", wrap_mode_name(m.wrap_s)},
          {"wrapT", wrap_mode_name(m.wrap_t)},
          {"width", m.width},
          {"height", m.height},
          {"stretchMax", m.stretch_max},
          {"stretchRounds", m.stretch_rounds},
          {"visiblePixels", m.visible_pixels},
          {"degeneratePixels", m.degenerate_pixels}};
}

void from_json(const nlohmann::json& json, TextureMapping& m) {
  const auto linear = json.at("linear").get<std::array<double, 4>>();  // row by row
  m.linear = glm::dmat2(linear[0], linear[2], linear[1], linear[3]);
  const auto offset = json.at("offset").get<std::array<double, 2>>();
  m.offset = {offset[0], offset[1]};
  m.has_cut = json.at("hasCut").get<std::array<bool, 2>>();
  m.cut = json.at("cut").get<std::array<double, 2>>();
  m.wrap_s = wrap_from(json.at("wrapS"));
  m.wrap_t = wrap_from(json.at("wrapT"));
  m.width = json_int(json, "width");
  m.height = json_int(json, "height");
  m.stretch_max = json.at("stretchMax").get<double>();
  m.stretch_rounds = json_int(json, "stretchRounds");
  m.visible_pixels = static_cast<std::size_t>(json_integer(json, "visiblePixels", 0, INT64_MAX));
  m.degenerate_pixels = static_cast<std::size_t>(json_integer(json, "degeneratePixels", 0, INT64_MAX));
  if (m.width < 1 || m.height < 1 || m.width > kGpuSideMax || m.height > kGpuSideMax)
    throw Error(ErrorCode::kInput, "a texture mapping is of " + std::to_string(m.width) + " x " +
                                       std::to_string(m.height) + " texels, expected 1 to 16384 per side");
}

}  // namespace multum
