// SPDX-License-Identifier: Apache-2.0
// The table of BRDFs. The row of a family holds everything that text forms, scenes, reports, help texts, the schema of
// jobs, references, fits and shaders need to know about it. A new family needs a row here and its shader
// (runtime_gl/shaders/brdf). This layer is below all code that reads it, so it holds only numbers and texts. The
// values, fits and measurements of a BRDF are in host/formats/brdf. A BRDF times the cosine is
//   k_d / pi (1 - F) max(n.l, 0) + k_s F f(n.h) V max(n.l, 0),
// where f is the density of facets, F is a function of v.h only, and V is shadowing and masking over 4 n.l n.v.
#pragma once

#include <span>
#include <string_view>

namespace multum {

enum class BrdfKind { kLambert, kBlinnPhong, kTorranceSparrow, kCookTorrance, kGgx, kCharlie, kMeasured };

/// The fields of struct Brdf in which the families store their numbers (kBrdfNumbers of host/formats/brdf/brdf.h lists
/// the fields). Two families can use the same field.
enum class BrdfField { kExponent, kSigma, kRoughness, kF0 };

struct BrdfMember {
  BrdfField field;
  std::string_view key;     // key in scenes and reports: "roughness"
  std::string_view symbol;  // placeholder in text forms: "ROUGHNESS"
  double low, high;
  std::string_view unit = {};  // such as "radians"; empty for a number without a unit
};

/// The way in which f is approximated by vMF lobes around h.
enum class BrdfFit {
  kNone,       // no highlight
  kEqualMean,  // one vMF with mean cosine (s + 1) / (s + 2), where s is the exponent
  kOne,        // one vMF whose kappa is the exponent
  kSum,        // a fitted sum (host/formats/brdf/vmf_terms.h)
};

struct BrdfFamily {
  BrdfKind kind;
  std::string_view name;  // name, such as "ggx"
  /// The width of f, and F0 if F is Schlick's term. The width has no default, and F0 has the default of struct Brdf.
  /// The list is empty if the text form of the family is only a name or a file.
  std::span<const BrdfMember> members = {};
  bool is_file = false;   // true if the text form is the path of a measurement
  float specular = 0.1f;  // default of k_s
  BrdfFit fit = BrdfFit::kSum;
  double sum_from = 0.0;      // smallest width at which the fitted sum is accurate; errors are measured with the fitted
                              // sum
  bool lights_alone = false;  // true if environments are not supported; lobes are then lit through the fitted sum
  bool is_normalised = true;  // true if the integral of f over the sphere is 1
  /// f per solid angle as a function of e = 1 - n.h, from 0 to 2. Null if there is no density, or if it comes from a
  /// file.
  double (*density)(float width, double e) = nullptr;
  /// Returns the exponent of the Blinn-Phong lobe with the same width. If null, the lobe with the same peak is used.
  double (*exponent)(float width) = nullptr;
  /// Returns V for cosines of at least 0, with the same limits at grazing angles as the shader. Null if V is 1.
  double (*visibility)(float width, double n_l, double n_v, double n_h, double v_h) = nullptr;
  std::span<const std::string_view> shader_flags = {}, shader_files = {};  // names of flags, and names of files in
                                                                           // runtime_gl/shaders/brdf
  bool shader_takes_terms = false;  // true if the shader uses the sum of terms.glsl, with one shader term per term of
                                    // the fit

  /// True if F is Schlick's term, and the diffuse part is multiplied by 1 - F.
  bool has_f0() const { return !members.empty() && members.back().field == BrdfField::kF0; }
  bool has_width() const { return !members.empty(); }
};

/// Returns the families in the order of help texts. The index of a family is its BrdfKind.
std::span<const BrdfFamily> brdf_families();
const BrdfFamily& brdf_family(BrdfKind kind);
/// Finds a family by name; returns null for an unknown name.
const BrdfFamily* find_brdf_family(std::string_view name);

/// Density of GGX: alpha^2 / (pi (1 - t^2 (1 - alpha^2))^2), t = 1 - e, e = 1 - n.h.
double ggx_density(double alpha, double e);

}  // namespace multum
