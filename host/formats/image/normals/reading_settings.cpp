// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/normals/reading_settings.h"

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "host/formats/image/normals/reading_parameters.h"

namespace multum {
namespace {

std::string text_of(const nlohmann::json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

const char* wrap_name(WrapMode mode, WrapOrigin origin) {
  return origin == WrapOrigin::kFound ? "auto" : wrap_mode_name(mode);
}

const char* yes_or_no(const std::optional<bool>& value) { return !value ? "auto" : *value ? "yes" : "no"; }

std::optional<bool> parse_yes_or_no(const std::string& text) {
  if (text != "yes" && text != "no") return std::nullopt;
  return text == "yes";
}

}  // namespace

void add_reading_settings(const NormalMapSettings& settings, nlohmann::json& json) {
  json["bump_format"] = choice_name(kBumpFormats, settings.bump_format);
  json["green"] = settings.green ? choice_name(kGreenAxes, *settings.green) : "auto";
  json["signed"] = yes_or_no(settings.is_signed);
  json["two_channel"] = yes_or_no(settings.two_channel);
  if (settings.z_range) json["z_range"] = choice_name(kZRanges, *settings.z_range);
  json["height_scale"] = settings.height_scale;
  if (settings.dequantize) json["dequantize"] = true;
  if (settings.normal_scale != 1.0f) json["normal_scale"] = settings.normal_scale;
  json["wrap"] = std::string(wrap_name(settings.wrap_s, settings.wrap_s_origin)) + "," +
                 wrap_name(settings.wrap_t, settings.wrap_t_origin);
  json["fixnan"] = choice_name(kFixNans, settings.fix_nan);
}

NormalMapSettings parse_reading_settings(const std::string& text) {
  NormalMapSettings settings;
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return settings;
  settings.bump_format = find_choice(kBumpFormats, text_of(json, "bump_format")).value_or(settings.bump_format);
  settings.green = find_choice(kGreenAxes, text_of(json, "green"));
  settings.is_signed = parse_yes_or_no(text_of(json, "signed"));
  settings.two_channel = parse_yes_or_no(text_of(json, "two_channel"));
  settings.z_range = find_choice(kZRanges, text_of(json, "z_range"));
  const auto scale = json.find("height_scale");
  if (scale != json.end() && scale->is_number() && std::isfinite(scale->get<float>()) && scale->get<float>() != 0.0f)
    settings.height_scale = scale->get<float>();
  const auto dequantize = json.find("dequantize");
  settings.dequantize = dequantize != json.end() && dequantize->is_boolean() && dequantize->get<bool>();
  const auto normal_scale = json.find("normal_scale");
  if (normal_scale != json.end() && normal_scale->is_number() && std::isfinite(normal_scale->get<float>()))
    settings.normal_scale = normal_scale->get<float>();
  const std::string wrap = text_of(json, "wrap");
  const std::size_t comma = wrap.find(',');
  const std::string wrap_t = comma == std::string::npos ? wrap : wrap.substr(comma + 1);
  if (wrap.substr(0, comma) == "auto") settings.wrap_s_origin = WrapOrigin::kFound;
  if (wrap_t == "auto") settings.wrap_t_origin = WrapOrigin::kFound;
  settings.wrap_s = parse_wrap_mode(wrap.substr(0, comma)).value_or(settings.wrap_s);
  settings.wrap_t = parse_wrap_mode(wrap_t).value_or(settings.wrap_t);
  settings.fix_nan = find_choice(kFixNans, text_of(json, "fixnan")).value_or(settings.fix_nan);
  return settings;
}

}  // namespace multum
