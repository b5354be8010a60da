// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_brdf.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "host/foundation/base/leading_number.h"

namespace multum {
namespace {

constexpr std::string_view kLambertText = "lambert", kRoughnessText = "roughness",
                           kBlinnPhongText = "blinn-phong:", kColouredText = " coloured";

// Parses a BRDF from a text that contains neither a shading method nor colours.
AccuracyBrdf parse_brdf_alone(const std::string& text) {
  if (text == kLambertText) return AccuracyBrdf::lambert();
  if (text == kRoughnessText) return AccuracyBrdf::roughness();
  if (text.starts_with(kBlinnPhongText)) {
    const AccuracyBrdf blinn_phong =
        AccuracyBrdf::blinn_phong(leading_number(text.substr(kBlinnPhongText.size())).value_or(0.0));
    if (blinn_phong.brdf_text() == text) return blinn_phong;
  }
  return AccuracyBrdf::named(text);
}

}  // namespace

AccuracyBrdf AccuracyBrdf::named(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return {AccuracyBrdfKind::kNamed, 0.0, std::move(name), {}, false};
}

std::string AccuracyBrdf::brdf_text() const {
  switch (kind) {
    case AccuracyBrdfKind::kLambert: return std::string(kLambertText);
    case AccuracyBrdfKind::kBlinnPhong: return fmt::format("{}{}", kBlinnPhongText, exponent);
    case AccuracyBrdfKind::kRoughness: return std::string(kRoughnessText);
    case AccuracyBrdfKind::kNamed: return name;
  }
  return name;
}

std::string AccuracyBrdf::text() const {
  std::string text = brdf_text();
  if (!shading.empty()) text += " " + shading;
  if (has_colours) text += kColouredText;
  return text;
}

AccuracyBrdf parse_accuracy_brdf(const std::string& text) {
  std::string rest = text;
  const bool has_colours = rest.ends_with(kColouredText);
  if (has_colours) rest.resize(rest.size() - kColouredText.size());
  const std::size_t space = rest.find(' ');
  AccuracyBrdf brdf = parse_brdf_alone(rest.substr(0, space));
  if (space != std::string::npos) brdf.shading = rest.substr(space + 1);
  brdf.has_colours = has_colours;
  if (brdf.text() == text) return brdf;
  brdf = {};
  brdf.kind = AccuracyBrdfKind::kNamed;
  brdf.name = text;
  return brdf;
}

}  // namespace multum
