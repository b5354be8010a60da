// SPDX-License-Identifier: Apache-2.0
// What a person says of how a map is to be read: the same words on every command line and in a bake's manifest.
#pragma once

#include <optional>

#include "host/base/choices.h"
#include "host/image/normal_map.h"

namespace multum {

inline const Choices<BumpFormat> kBumpFormats = {
    {"auto", BumpFormat::kAuto}, {"height", BumpFormat::kHeight}, {"normal", BumpFormat::kNormal}};
inline const Choices<GreenAxis> kGreenAxes = {{"up", GreenAxis::kUp}, {"down", GreenAxis::kDown}};
inline const Choices<FixNan> kFixNans = {{"none", FixNan::kNone}, {"black", FixNan::kBlack}, {"box3", FixNan::kBox3}};

/// Unset: not said.
struct ReadingOptions {
  std::optional<BumpFormat> bump_format;
  std::optional<GreenAxis> green;
  bool is_signed = false, is_unsigned = false, two_channel = false;
  std::optional<float> height_scale;
  std::optional<float> normal_scale;
  std::optional<FixNan> fix_nan;
  std::optional<float> repair_share_max;
};

/// What was said takes the place of what `settings` hold.
void apply(const ReadingOptions& options, NormalMapSettings& settings);

}  // namespace multum
