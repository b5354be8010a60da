// SPDX-License-Identifier: Apache-2.0
// Identifies what an error was measured for. This is a BRDF, its shading method, and whether colours are included. The
// text form, which is used in tables, reports and file headers, is written and parsed only here.
#pragma once

#include <string>

namespace multum {

enum class AccuracyBrdfKind {
  kLambert,
  kBlinnPhong,  // exponent in AccuracyBrdf::exponent
  kRoughness,   // a highlight whose width comes from the map
  kNamed,       // another highlight, named by AccuracyBrdf::name
};

struct AccuracyBrdf {
  AccuracyBrdfKind kind = AccuracyBrdfKind::kLambert;
  double exponent = 0.0;  // exponent of kBlinnPhong
  std::string name;       // name of kNamed, such as "ggx:0.5"
  std::string shading;    // "toksvig", "lean" or another method if there are several methods; otherwise empty
  bool has_colours = false;

  static AccuracyBrdf lambert() { return {}; }
  static AccuracyBrdf blinn_phong(double exponent) { return {AccuracyBrdfKind::kBlinnPhong, exponent, {}, {}, false}; }
  static AccuracyBrdf roughness() { return {AccuracyBrdfKind::kRoughness, 0.0, {}, {}, false}; }
  /// Replaces spaces in the name with underscores, because a space separates the name from the shading method.
  static AccuracyBrdf named(std::string name);

  /// True if the BRDFs are equal. Ignores shading methods and colours.
  bool is_same_brdf(const AccuracyBrdf& other) const {
    return kind == other.kind && exponent == other.exponent && name == other.name;
  }
  bool operator==(const AccuracyBrdf&) const = default;

  /// Formats only the BRDF, as in "blinn-phong:20".
  std::string brdf_text() const;
  /// Formats everything, as in "blinn-phong:20 lean coloured".
  std::string text() const;
};

/// Parses the output of text(). A text that is not recognised is kept as a name, because another program may have
/// written it.
AccuracyBrdf parse_accuracy_brdf(const std::string& text);

}  // namespace multum
