// SPDX-License-Identifier: Apache-2.0
// The options that say what a map's numbers mean: the same in every program that reads one.
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "host/image/normal_map.h"

namespace multum {

struct ReadingOptions {
  std::optional<BumpFormat> bump_format;
  std::string green;
  bool is_signed = false, is_unsigned = false, two_channel = false;
  std::optional<float> height_scale;
  std::optional<FixNan> fix_nan;
  std::optional<float> repair_share_max;
};

/// --help shows what `options` hold already as the defaults; it names none when they are empty.
void add_reading_options(CLI::App& app, ReadingOptions& options);

/// What was given takes the place of what `settings` hold.
void apply(const ReadingOptions& options, NormalMapSettings& settings);

}  // namespace multum
