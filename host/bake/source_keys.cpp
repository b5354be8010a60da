// SPDX-License-Identifier: Apache-2.0
#include "host/bake/source_keys.h"

#include <limits>
#include <utility>

namespace multum {
namespace {

void read_reading(const StrictTable& table, ReadingOptions& reading) {
  read_choice(table, "bumpformat", kBumpFormats, reading.bump_format);
  read_choice(table, "green", kGreenAxes, reading.green);
  // One question with two answers: what a map says of it replaces all that [defaults] say.
  if (table.has("signed") || table.has("unsigned")) {
    reading.is_signed = table.boolean("signed", false);
    reading.is_unsigned = table.boolean("unsigned", false);
    if (reading.is_signed && reading.is_unsigned) table.refuse("unsigned", "is true, and signed is too: expected one");
  }
  reading.two_channel = table.boolean("two_channel", reading.two_channel);
  constexpr double kFloatMax = std::numeric_limits<float>::max();
  read_number(table, "height_scale", {-kFloatMax, kFloatMax, false, false, "a number other than 0"},
              reading.height_scale);
  if (reading.height_scale == 0.0f) table.refuse("height_scale", "is 0, expected a number other than 0");
  read_number(table, "normal_scale", {-kFloatMax, kFloatMax, false, false, "a number"}, reading.normal_scale);
  read_choice(table, "fixnan", kFixNans, reading.fix_nan);
  read_number(table, "repair_max", {0.0, 1.0, false, false, "a number from 0 to 1"}, reading.repair_share_max);
}

}  // namespace

void read_number(const StrictTable& table, const std::string& key, const NumberRange& range,
                 std::optional<float>& value) {
  if (table.has(key)) value = static_cast<float>(table.number(key, range, 0.0));
}

const std::vector<std::string>& source_keys() {
  static const std::vector<std::string> keys = {"bumpformat",   "green",        "signed", "unsigned",   "two_channel",
                                                "height_scale", "normal_scale", "fixnan", "repair_max", "checknan",
                                                "wrap",         "swrap",        "twrap",  "albedo",     "roughness",
                                                "gloss",        "weights"};
  return keys;
}

void read_source_keys(const StrictTable& table, MapOptions& map) {
  read_reading(table, map.reading);
  map.check_nan = table.boolean("checknan", map.check_nan);
  read_choice(table, "wrap", kMapWraps, map.wrap);
  read_choice(table, "swrap", kMapWraps, map.wrap_s);
  read_choice(table, "twrap", kMapWraps, map.wrap_t);
  // One map under either name: what is said of a map replaces what [defaults] say.
  if (table.has("roughness") || table.has("gloss")) {
    if (table.has("roughness") && table.has("gloss"))
      table.refuse("gloss", "is given beside roughness: expected one of them, since roughness = 1 - gloss");
    map.roughness.reset(), map.gloss.reset();
  }
  for (const auto& [key, value] : {std::pair{"albedo", &map.albedo}, std::pair{"roughness", &map.roughness},
                                   std::pair{"gloss", &map.gloss}, std::pair{"weights", &map.weights}})
    if (table.has(key)) *value = table.text(key, "");
}

}  // namespace multum
