// SPDX-License-Identifier: Apache-2.0
#include "host/formats/brdf/brdf_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "host/formats/brdf/measured_file.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::string_view kExpected =
    "lambert, blinn-phong:S with S 1..100000, torrance-sparrow:SIGMA or cook-torrance:SIGMA[,F0] with SIGMA 0.002..1 "
    "radians, ggx:ROUGHNESS[,F0] with ROUGHNESS 0.05..1 (F0 0..1, grey or r,g,b), or a measured BRDF's file";

struct Family {
  std::string_view name;
  BrdfKind kind;
  float Brdf::*parameter;
  float low, high;
  bool has_f0;
};
constexpr Family kFamilies[] = {
    {"blinn-phong", BrdfKind::kBlinnPhong, &Brdf::exponent, 1.0f, 1e5f, false},
    {"torrance-sparrow", BrdfKind::kTorranceSparrow, &Brdf::sigma, 0.002f, 1.0f, false},
    {"cook-torrance", BrdfKind::kCookTorrance, &Brdf::sigma, 0.002f, 1.0f, true},
    {"ggx", BrdfKind::kGgx, &Brdf::roughness, 0.05f, 1.0f, true},
};

// Nothing where one of them is no number.
std::vector<float> numbers_of(std::string_view text) {
  std::vector<float> numbers;
  for (;;) {
    const std::string_view word = text.substr(0, text.find(','));
    float value = 0.0f;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return {};
    numbers.push_back(value);
    if (word.size() == text.size()) return numbers;
    text.remove_prefix(word.size() + 1);
  }
}

// Its first number, then F0 where it has one; false: not so.
bool read_parameters(const Family& family, std::string_view text, Brdf& brdf) {
  const std::vector<float> n = numbers_of(text);
  if (n.empty() || !(n[0] >= family.low && n[0] <= family.high)) return false;
  if (n.size() != 1 && !(family.has_f0 && (n.size() == 2 || n.size() == 4))) return false;
  brdf.kind = family.kind;
  brdf.*family.parameter = n[0];
  if (n.size() == 1) return true;
  brdf.f0 = n.size() == 2 ? glm::vec3(n[1]) : glm::vec3(n[1], n[2], n[3]);
  for (int i = 0; i < 3; ++i)
    if (!(brdf.f0[i] >= 0.0f && brdf.f0[i] <= 1.0f)) return false;
  return true;
}

const Family* find_family(std::string_view text) {
  for (const Family& family : kFamilies)
    if (text.starts_with(family.name) && text.substr(family.name.size()).starts_with(':')) return &family;
  return nullptr;
}

}  // namespace

bool is_brdf_file(const std::string& text) { return text != "lambert" && find_family(text) == nullptr; }

Brdf parse_brdf(const std::string& option, const std::string& text, int term_count) {
  Brdf brdf;
  brdf.term_count = term_count;
  const auto refuse = [&] {
    throw Error(ErrorCode::kUsage, fmt::format("{} '{}': expected {}", option, text, kExpected));
  };
  if (text == "lambert") {
    brdf.kind = BrdfKind::kLambert;
    brdf.specular = glm::vec3(0.0f);
  } else if (const Family* family = find_family(text)) {
    if (!read_parameters(*family, std::string_view(text).substr(family->name.size() + 1), brdf)) refuse();
    if (family->has_f0) brdf.specular = glm::vec3(1.0f);  // Schlick's term is in their specular part already
  } else if (std::filesystem::exists(text)) {
    brdf.kind = BrdfKind::kMeasured;
    brdf.measured = std::make_shared<const MeasuredBrdf>(read_measured_brdf(text));
    brdf.diffuse = glm::vec3(brdf.measured->diffuse);
    brdf.specular = glm::vec3(1.0f);
  } else {
    refuse();
  }
  return brdf;
}

}  // namespace multum
