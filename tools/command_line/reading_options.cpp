// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/reading_options.h"

#include <fmt/format.h>

#include "tools/command_line/choices.h"

namespace multum {
void add_reading_options(CLI::App& app, ReadingOptions& o) {
  const std::string found = o.bump_format ? " (default: found)" : "";
  const auto show_default = [](CLI::Option* option, const std::optional<float>& value) {
    if (value) option->default_str(fmt::format("{}", *value));
    return option;
  };
  add_choice(app, "--bumpformat", o.bump_format, kBumpFormats, "what the file is; auto: found from its statistics");
  add_choice(app, "--green", o.green, kGreenAxes, "green points up (OpenGL) or down (DirectX)" + found);
  auto* is_signed = app.add_flag("--signed", o.is_signed, "channel values are the vector, -1..1" + found);
  app.add_flag("--unsigned", o.is_unsigned, "channel values are encoded, 0..1" + found)->excludes(is_signed);
  app.add_flag("--two-channel", o.two_channel, "only x and y are stored; z is rebuilt" + found);
  show_default(
      app.add_option("--height-scale", o.height_scale, "height field: height in texels of a value difference of 1"),
      o.height_scale);
  show_default(
      app.add_option("--normal-scale", o.normal_scale, "normal map: x and y times this, as glTF's normalTexture.scale"),
      o.normal_scale);
  add_choice(app, "--fixnan", o.fix_nan, kFixNans,
             "repair NaN and Inf: none (refuse), black (flat), box3 (mean of the neighbours)");
  show_default(app.add_option("--repair-max", o.repair_share_max,
                              "refuse a file that needs more repairs than this share of its texels"),
               o.repair_share_max)
      ->check(CLI::Range(0.0, 1.0));
}

}  // namespace multum
