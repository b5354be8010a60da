// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/lobe_lookups.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>

#include "host/formats/asset/lobes/movmf_reader.h"

namespace multum {
namespace {

const glm::dvec3 kLuminance(0.2126, 0.7152, 0.0722);

}  // namespace

LobeLevels::LobeLevels(const std::string& path, WrapMode wrap_s, WrapMode wrap_t, std::uint64_t bytes_max) {
  MovmfReader reader(path);
  const MovmfMipmap& header = reader.header();
  count_ = header.lobe_count();
  const int first = header.header.first_level, last = static_cast<int>(header.levels.size()) - 1;
  frame_ = {header.levels[size_of(first)].width, header.levels[size_of(first)].height, last - first + 1, wrap_s,
            wrap_t};
  levels_.resize(size_of(frame_.level_count));
  finest_held_ = frame_.level_count;
  for (int level = frame_.level_count; level-- > 0;) {
    const auto& size = header.levels[size_of(first + level)];
    const std::size_t of_lobe = sizeof(glm::vec4) + (header.header.has_colours ? sizeof(glm::vec3) : 0);
    const std::uint64_t bytes = of_lobe * size_of(count_) * size_of(size.width) * size_of(size.height);
    if (bytes > bytes_max) break;
    bytes_max -= bytes;
    levels_[size_of(level)] = reader.read_level(first + level, 0, size.height);
    finest_held_ = level;
  }
}

LobeLevels::LobeLevels(MovmfMipmap baked, WrapMode wrap_s, WrapMode wrap_t) {
  const int first = baked.header.first_level, last = static_cast<int>(baked.levels.size()) - 1;
  count_ = static_cast<int>(baked.levels.back().lobes.size());
  frame_ = {baked.levels[size_of(first)].width, baked.levels[size_of(first)].height, last - first + 1, wrap_s, wrap_t};
  levels_.assign(std::make_move_iterator(baked.levels.begin() + first), std::make_move_iterator(baked.levels.end()));
}

glm::dvec4 LobeLevels::Layer::texel(int level, int x, int y) const {
  const MovmfLevel& at = levels.levels_[size_of(level)];
  return glm::dvec4(at.lobes[lobe][size_of(y) * size_of(at.width) + size_of(x)]);
}

glm::dvec4 LobeLevels::ColourLayer::texel(int level, int x, int y) const {
  const MovmfLevel& at = levels.levels_[size_of(level)];
  const glm::vec3& colour = at.colours[lobe][size_of(y) * size_of(at.width) + size_of(x)];
  return {glm::dot(glm::dvec3(colour), kLuminance), 0.0, 0.0, 0.0};
}

glm::dvec4 LobeLevels::Layer::linear(int level, const glm::dvec2& place) const {
  return linear_lookup(levels.frame_, level, place, [&](int x, int y) { return texel(level, x, y); });
}

glm::dvec4 LobeLevels::ColourLayer::linear(int level, const glm::dvec2& place) const {
  return linear_lookup(levels.frame_, level, place, [&](int x, int y) { return texel(level, x, y); });
}

double LobeLevels::level_of(const glm::dvec2& along_x, const glm::dvec2& along_y, double bias) const {
  const glm::dvec2 size(frame_.width, frame_.height);
  return std::log2(std::max({glm::length(along_x * size), glm::length(along_y * size), 1e-15})) + bias;
}

glm::ivec2 LobeLevels::grid(int count, const glm::dvec2& along_x, const glm::dvec2& along_y) const {
  const glm::dvec2 size(frame_.width, frame_.height);
  const double length_x = glm::length(along_x * size), length_y = glm::length(along_y * size);
  const double ratio = std::max(length_x, length_y) / std::max(std::min(length_x, length_y), 1e-20);
  const double most = std::floor(0.5 * std::log2(count) + 1e-3);
  const double octaves = std::clamp(std::ceil(0.5 * std::log2(count / (2.0 * ratio)) - 1e-3), 0.0, most);
  const int across = 1 << static_cast<int>(octaves), along = count / across;
  return length_x > length_y ? glm::ivec2(along, across) : glm::ivec2(across, along);
}

PixelTaps LobeLevels::taps_of(const glm::dvec2& place, double level) const {
  PixelTaps taps;
  const int last = frame_.level_count - 1;
  const double lod = std::clamp(level, static_cast<double>(std::min(finest_held_, last)), static_cast<double>(last));
  taps.levels[0] = static_cast<int>(lod);
  taps.levels[1] = std::min(taps.levels[0] + 1, last);
  taps.coarser_share = lod - taps.levels[0];
  taps.places.push_back(place);
  return taps;
}

std::vector<glm::dvec4> LobeLevels::at(const glm::dvec2& place, double level) const {
  const PixelTaps taps = taps_of(place, level);
  std::vector<glm::dvec4> lobes;
  for (int lobe = 0; lobe < count_; ++lobe) lobes.push_back(taps.mean(Layer{*this, size_of(lobe)}));
  return lobes;
}

std::vector<double> LobeLevels::luminances(const glm::dvec2& place, double level) const {
  const PixelTaps taps = taps_of(place, level);
  std::vector<double> made;
  for (int lobe = 0; lobe < count_; ++lobe) made.push_back(taps.mean(ColourLayer{*this, size_of(lobe)}).x);
  return made;
}

double LobeLevels::finest_luminance(const glm::dvec2& place, const glm::dvec3& normal) const {
  const int level = std::min(finest_held_, frame_.level_count - 1);
  const MovmfLevel& at = levels_[size_of(level)];
  const int x = wrapped_texel(static_cast<int>(std::floor(place.x * at.width)), at.width, frame_.wrap_s);
  const int y = wrapped_texel(static_cast<int>(std::floor(place.y * at.height)), at.height, frame_.wrap_t);
  double nearest = -2.0, luminance = 0.0;
  for (int lobe = 0; lobe < count_; ++lobe) {
    const glm::dvec4 one = Layer{*this, size_of(lobe)}.texel(level, x, y);
    const double length = glm::length(glm::dvec3(one));
    if (one.w <= 1e-3 || length <= 1e-6) continue;
    const double cosine = glm::dot(glm::dvec3(one), normal) / length;
    if (cosine <= nearest) continue;
    nearest = cosine;
    luminance = ColourLayer{*this, size_of(lobe)}.texel(level, x, y).x / one.w;
  }
  return luminance;
}

}  // namespace multum
