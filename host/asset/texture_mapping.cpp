// SPDX-License-Identifier: Apache-2.0
#include "host/asset/texture_mapping.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr int kSideMax = 16384;

WrapMode wrap_from(const nlohmann::json& json) {
  const std::string name = json.get<std::string>();
  const std::optional<WrapMode> mode = parse_wrap_mode(name);
  if (!mode || (*mode != WrapMode::kClamp && *mode != WrapMode::kPeriodic))
    throw Error(ErrorCode::kInput, "the wrap mode of a texture mapping is '" + name + "', expected clamp or periodic");
  return *mode;
}

// Moves the three coordinates of a triangle into the period that begins at the cut, without tearing it: they are
// unwrapped around the first corner, and the triangle's middle decides.
void unwrap(std::array<double, 3>& c, double cut) {
  for (int i = 1; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    c[k] -= std::round(c[k] - c[0]);
  }
  const double shift = std::floor((c[0] + c[1] + c[2]) / 3.0 - cut);
  for (double& value : c) value -= shift;
}

}  // namespace

std::vector<glm::vec2> mapped_corners(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices,
                                      const TextureMapping& mapping) {
  std::vector<glm::vec2> corners;
  corners.reserve(indices.size());
  for (std::size_t t = 0; t + 2 < indices.size(); t += 3) {
    std::array<std::array<double, 3>, 2> uv;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec2& from = uvs[indices[t + k]];
      uv[0][k] = static_cast<double>(from.x);
      uv[1][k] = static_cast<double>(from.y);
    }
    for (std::size_t d = 0; d < 2; ++d)
      if (mapping.has_cut[d]) unwrap(uv[d], mapping.cut[d]);
    for (std::size_t k = 0; k < 3; ++k)
      corners.emplace_back(mapping.linear * glm::dvec2(uv[0][k], uv[1][k]) + mapping.offset);
  }
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
          {"visiblePixels", m.visible_pixels}};
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
  m.width = json.at("width").get<int>();
  m.height = json.at("height").get<int>();
  m.stretch_max = json.at("stretchMax").get<double>();
  m.stretch_rounds = json.at("stretchRounds").get<int>();
  m.visible_pixels = json.at("visiblePixels").get<std::size_t>();
  if (m.width < 1 || m.height < 1 || m.width > kSideMax || m.height > kSideMax)
    throw Error(ErrorCode::kInput, "a texture mapping is of " + std::to_string(m.width) + " x " +
                                       std::to_string(m.height) + " texels, expected 1 to 16384 a side");
}

}  // namespace multum
