// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/normals/reading_parameters.h"

namespace multum {
namespace {

void apply_wrap(const std::optional<std::string>& text, WrapMode& mode, WrapOrigin& origin) {
  if (!text) return;
  // With "auto", the map decides later. Until then, it counts as repeating.
  const bool is_found = *text == "auto";
  mode = is_found ? WrapMode::kPeriodic : parse_wrap_mode(*text).value_or(mode);
  origin = is_found ? WrapOrigin::kFound : WrapOrigin::kSaid;
}

}  // namespace

std::optional<MapSurface> map_surface(const ParameterValues& values) { return values.choice("surface", kMapSurfaces); }

std::optional<ZRange> z_range(const ParameterValues& values) { return values.choice("z_range", kZRanges); }

void apply_reading(const ParameterValues& values, NormalMapSettings& settings) {
  settings.bump_format = values.choice("bumpformat", kBumpFormats).value_or(settings.bump_format);
  if (const auto green = values.choice("green", kGreenAxes)) settings.green = green;
  if (values.flag("signed") || values.flag("unsigned")) settings.is_signed = values.flag("signed");
  if (values.flag("two_channel")) settings.two_channel = true;
  if (const auto range = z_range(values)) settings.z_range = range;
  if (const auto scale = values.number("height_scale")) settings.height_scale = static_cast<float>(*scale);
  if (values.flag("dequantize")) settings.dequantize = true;
  if (const auto scale = values.number("normal_scale")) settings.normal_scale = static_cast<float>(*scale);
  settings.fix_nan = values.choice("fixnan", kFixNans).value_or(settings.fix_nan);
  if (const auto share = values.number("repair_max")) settings.repair_share_max = static_cast<float>(*share);
  if (values.flag("checknan")) settings.check_nan = true;
  for (const char* name : {"wrap", "swrap"}) apply_wrap(values.text(name), settings.wrap_s, settings.wrap_s_origin);
  for (const char* name : {"wrap", "twrap"}) apply_wrap(values.text(name), settings.wrap_t, settings.wrap_t_origin);
}

}  // namespace multum
