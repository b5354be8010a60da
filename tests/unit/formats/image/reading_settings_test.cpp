// SPDX-License-Identifier: Apache-2.0
// Tests that the settings with which a map was read are stored as text in a baked file and can be read again.
#include "host/formats/image/normals/reading_settings.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace multum {
namespace {

std::string to_text(const NormalMapSettings& settings) {
  nlohmann::json json;
  add_reading_settings(settings, json);
  return json.dump();
}

TEST(ReadingSettingsTest, WhatIsWrittenIsReadBack) {
  NormalMapSettings settings;
  EXPECT_EQ(to_text(parse_reading_settings(to_text(settings))), to_text(settings));
  settings = {.bump_format = BumpFormat::kHeight,
              .green = GreenAxis::kDown,
              .is_signed = true,
              .two_channel = false,
              .height_scale = 0.1f,
              .dequantize = true,
              .normal_scale = 0.3f,
              .wrap_s = WrapMode::kMirror,
              .wrap_t = WrapMode::kBlack,
              .fix_nan = FixNan::kNone};
  const std::string text = to_text(settings);
  EXPECT_EQ(to_text(parse_reading_settings(text)), text);
  EXPECT_EQ(parse_reading_settings(text).height_scale, 0.1f);
  EXPECT_EQ(parse_reading_settings(text).normal_scale, 0.3f);
  EXPECT_TRUE(parse_reading_settings(text).dequantize);
  EXPECT_EQ(parse_reading_settings(text).wrap_t, WrapMode::kBlack);
  EXPECT_EQ(parse_reading_settings(text).z_range, std::nullopt);
  settings.z_range = ZRange::kPositive;
  EXPECT_EQ(parse_reading_settings(to_text(settings)).z_range, ZRange::kPositive);
}

TEST(ReadingSettingsTest, WhatIsNotUnderstoodStaysAtItsDefault) {
  const std::string defaults = to_text({});
  for (const char* text : {"", "{", "[1]", "{\"wrap\":7,\"green\":[],\"signed\":\"perhaps\",\"height_scale\":\"8\"}",
                           "{\"height_scale\":0,\"wrap\":\"round\",\"fixnan\":null}", "{\"height_scale\":1e999}"})
    EXPECT_EQ(to_text(parse_reading_settings(text)), defaults) << text;
}

}  // namespace
}  // namespace multum
