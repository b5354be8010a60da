// SPDX-License-Identifier: Apache-2.0
// Makes assets of texture inference whose fields all differ from their defaults and from each other, and compares every
// field.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/fields/inferred/texture_mapping.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {

inline TextureMapping unusual_mapping() {
  TextureMapping mapping;
  mapping.linear = glm::dmat2(1.5, -0.25, 1.0 / 3.0, 1e-9);  // columns
  mapping.offset = {0.1, -7.25};
  mapping.has_cut = {false, true};
  mapping.cut = {0.375, -0.0625};
  mapping.wrap_s = WrapMode::kPeriodic;
  mapping.wrap_t = WrapMode::kClamp;
  mapping.width = 203;
  mapping.height = 16384;
  mapping.stretch_max = 1.0 / 7.0;
  mapping.stretch_rounds = 5;
  mapping.visible_pixels = (std::size_t{1} << 40) + 1;
  mapping.degenerate_pixels = 17;
  return mapping;
}

inline void expect_same(const TextureMapping& found, const TextureMapping& expected) {
  EXPECT_EQ(found.linear, expected.linear);
  EXPECT_EQ(found.offset, expected.offset);
  EXPECT_EQ(found.has_cut, expected.has_cut);
  EXPECT_EQ(found.cut, expected.cut);
  EXPECT_EQ(found.wrap_s, expected.wrap_s);
  EXPECT_EQ(found.wrap_t, expected.wrap_t);
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.stretch_max, expected.stretch_max);
  EXPECT_EQ(found.stretch_rounds, expected.stretch_rounds);
  EXPECT_EQ(found.visible_pixels, expected.visible_pixels);
  EXPECT_EQ(found.degenerate_pixels, expected.degenerate_pixels);
}

/// Returns 16 different numbers without short decimals.
inline glm::dmat4 unusual_matrix(double seed) {
  glm::dmat4 m;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) m[c][r] = seed + (4 * c + r) / 7.0;
  return m;
}

/// Calls `visit` with the position of every key and every array element below `json`, including those in matrices,
/// mappings and similar objects.
inline void for_each_place(const nlohmann::json& json, const nlohmann::json::json_pointer& place,
                           const std::function<void(const nlohmann::json::json_pointer&)>& visit) {
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) {
    const auto below = json.is_object() ? place / key : place / static_cast<std::size_t>(std::stoul(key));
    visit(below);
    for_each_place(value, below, visit);
  }
}

/// Damages a JSON file at every position, one position at a time. `read` must refuse each damaged file and name it.
/// Values in objects called one of `names` may be missing.
inline void expect_damage_is_refused(const std::string& path, const std::string& kind,
                                     const std::set<std::string>& names,
                                     const std::function<void(const std::string&)>& read) {
  const nlohmann::json whole = nlohmann::json::parse(read_bytes(path));
  int missing_count = 0;
  for_each_place(whole, nlohmann::json::json_pointer(), [&](const nlohmann::json::json_pointer& place) {
    SCOPED_TRACE(place.to_string());
    const auto above = place.parent_pointer();
    const bool is_name = !above.empty() && names.count(above.back()) > 0;  // objects may have any names, or be missing
    if (whole.at(above).is_object() && !is_name) {
      nlohmann::json missing = whole;
      missing.at(above).erase(place.back());
      write_bytes(path, missing.dump());
      expect_error(ErrorCode::kInput, {path + ": " + kind, "'" + place.back() + "' not found"}, [&] { read(path); });
      ++missing_count;
    }
    nlohmann::json wrong = whole;  // replaces numbers, references, lists and objects by text, and text by a list
    if (whole.at(place).is_string()) wrong.at(place) = {1};
    else wrong.at(place) = "1";
    write_bytes(path, wrong.dump());
    expect_error(ErrorCode::kInput, {path + ": " + kind, "type"}, [&] { read(path); });
  });
  EXPECT_GT(missing_count, 20);
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, whole.dump().size() / 2, whole.dump().size() - 1}) {
    write_bytes(path, whole.dump().substr(0, size));
    expect_error(ErrorCode::kInput, {path + ": " + kind, "parse error"}, [&] { read(path); });
  }
  write_bytes(path, "[1, 2]");
  expect_error(ErrorCode::kInput, {path + ": " + kind}, [&] { read(path); });
  write_bytes(path, "\xff\xfe{}");
  expect_error(ErrorCode::kInput, {path + ": " + kind, "parse error"}, [&] { read(path); });
  write_bytes(path, whole.dump());
  EXPECT_NO_THROW(read(path)) << "as it was";
}

/// Sets one value of a JSON file while `body` runs.
inline void with_value(const std::string& path, const std::string& place, const nlohmann::json& value,
                       const std::function<void()>& body) {
  const std::string before = read_bytes(path);
  nlohmann::json json = nlohmann::json::parse(before);
  json.at(nlohmann::json::json_pointer(place)) = value;
  write_bytes(path, json.dump());
  SCOPED_TRACE(place + " = " + value.dump());
  body();
  write_bytes(path, before);
}

}  // namespace multum::testing
