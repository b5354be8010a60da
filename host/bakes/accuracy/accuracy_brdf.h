// SPDX-License-Identifier: Apache-2.0
// Says what an error was measured of: a BRDF, the way to shade it, and whether colours are in. Its text, in tables,
// reports and headers of files, is made and read here alone.
#pragma once

#include <string>

namespace multum {

enum class AccuracyBrdfKind {
  kLambert,
  kBlinnPhong,  // of AccuracyBrdf::exponent
  kRoughness,   // a highlight whose width is the map's
  kNamed,       // another highlight: AccuracyBrdf::name
};

struct AccuracyBrdf {
  AccuracyBrdfKind kind = AccuracyBrdfKind::kLambert;
  double exponent = 0.0;  // of kBlinnPhong
  std::string name;       // of kNamed: "ggx:0.5"
  std::string shading;    // "toksvig", "lean", ... where there are several ways; else empty
  bool has_colours = false;

  static AccuracyBrdf lambert() { return {}; }
  static AccuracyBrdf blinn_phong(double exponent) { return {AccuracyBrdfKind::kBlinnPhong, exponent, {}, {}, false}; }
  static AccuracyBrdf roughness() { return {AccuracyBrdfKind::kRoughness, 0.0, {}, {}, false}; }
  /// Spaces of the name become underscores: after a space comes the way to shade it.
  static AccuracyBrdf named(std::string name);

  /// Is it the same BRDF, however shaded, with colours or without?
  bool is_same_brdf(const AccuracyBrdf& other) const {
    return kind == other.kind && exponent == other.exponent && name == other.name;
  }
  bool operator==(const AccuracyBrdf&) const = default;

  /// "blinn-phong:20": the BRDF alone.
  std::string brdf_text() const;
  /// "blinn-phong:20 lean coloured".
  std::string text() const;
};

/// What text() wrote. Other programs' texts are kept as names.
AccuracyBrdf parse_accuracy_brdf(const std::string& text);

}  // namespace multum
