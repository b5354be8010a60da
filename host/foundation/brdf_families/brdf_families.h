// SPDX-License-Identifier: Apache-2.0
// The table of BRDFs: a row is all that text forms, scenes, reports, help texts, the schema of jobs, references, fits
// and shaders know of a family. A new one is a row here and the text of its shader (runtime_gl/shaders/brdf). It stands
// below all that reads it, and so knows numbers and texts alone: host/formats/brdf has a BRDF's values, fits and
// measurements. Times the cosine a BRDF is
//   k_d / pi (1 - F) max(n.l, 0) + k_s F f(n.h) V max(n.l, 0),
// f the density of facets, F what depends on v.h alone, V shadowing and masking over 4 n.l n.v.
#pragma once

#include <span>
#include <string_view>

namespace multum {

enum class BrdfKind { kLambert, kBlinnPhong, kTorranceSparrow, kCookTorrance, kGgx, kCharlie, kMeasured };

/// The field of struct Brdf that a member is kept in (kBrdfNumbers of host/formats/brdf/brdf.h); families share them.
enum class BrdfField { kExponent, kSigma, kRoughness, kF0 };

struct BrdfMember {
  BrdfField field;
  std::string_view key;     // in scenes and reports: "roughness"
  std::string_view symbol;  // in text forms: "ROUGHNESS"
  double low, high;
  std::string_view unit = {};  // "radians"; empty: a number
};

/// How vMF lobes take f: as a sum of vMFs around h.
enum class BrdfFit {
  kNone,       // no highlight
  kEqualMean,  // one of the mean cosine (s + 1) / (s + 2), s the exponent
  kOne,        // one, whose kappa is the exponent
  kSum,        // a fitted sum (host/formats/brdf/vmf_terms.h)
};

struct BrdfFamily {
  BrdfKind kind;
  std::string_view name;  // "ggx"
  // Its width, and F0 where F is Schlick's term; a width has no default, F0 has that of struct Brdf. None: a name
  // alone, or a file.
  std::span<const BrdfMember> members = {};
  bool is_file = false;   // its text form is the path of a measurement
  float specular = 0.1f;  // k_s where nothing is said
  BrdfFit fit = BrdfFit::kSum;
  double sum_from = 0.0;      // the least width that the fitted sum is near, with which errors are measured
  bool lights_alone = false;  // no environment: its light over lobes is that of the sum
  bool is_normalised = true;  // the integral of f over the sphere is 1
  /// f per solid angle of e = 1 - n.h, 0..2. Null: none, or that of a file.
  double (*density)(float width, double e) = nullptr;
  /// The exponent of the Blinn-Phong that is as wide. Null: of the one that has the same peak.
  double (*exponent)(float width) = nullptr;
  /// V at cosines of at least 0, with the bounds at grazing angles that its shader has. Null: 1.
  double (*visibility)(float width, double n_l, double n_v, double n_h, double v_h) = nullptr;
  std::span<const std::string_view> shader_flags = {}, shader_files = {};  // files of runtime_gl/shaders/brdf
  bool shader_takes_terms = false;  // the sum of terms.glsl, of as many as the fit has

  /// F is Schlick's term, and the diffuse part times 1 - F.
  bool has_f0() const { return !members.empty() && members.back().field == BrdfField::kF0; }
  bool has_width() const { return !members.empty(); }
};

/// In the order in which they are shown; each at the place of its kind.
std::span<const BrdfFamily> brdf_families();
const BrdfFamily& brdf_family(BrdfKind kind);
/// Null: there is none of this name.
const BrdfFamily* find_brdf_family(std::string_view name);

/// GGX of alpha, alpha^2 / (pi (1 - t^2 (1 - alpha^2))^2), t = 1 - e, e = 1 - n.h.
double ggx_density(double alpha, double e);

}  // namespace multum
