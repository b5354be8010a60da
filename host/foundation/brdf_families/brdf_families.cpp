// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/brdf_families/brdf_families.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace multum {
namespace {

using Text = std::string_view;

double width_itself(float width) { return static_cast<double>(width); }

// Computes the alpha of glTF in single precision, as shaders do.
double alpha_of(float roughness) { return static_cast<double>(roughness * roughness); }

constexpr BrdfMember kRoughness = {BrdfField::kRoughness, "roughness", "ROUGHNESS", 0.05, 1.0};
constexpr BrdfMember kSigma = {BrdfField::kSigma, "sigma", "SIGMA", 0.002, 1.0, "radians"};
constexpr BrdfMember kF0 = {BrdfField::kF0, "f0", "F0", 0.0, 1.0};

// Blinn-Phong: f = (s + 1) / (2 pi) (n.h)^s.
constexpr BrdfMember kBlinnPhongMembers[] = {{BrdfField::kExponent, "exponent", "S", 1.0, 1e5}};
constexpr Text kBlinnPhongFlags[] = {"MULTUM_BLINN_PHONG"}, kBlinnPhongFiles[] = {"blinn_phong.glsl"};

double blinn_phong_density(float width, double e) {
  const auto s = static_cast<double>(width);
  return e < 1.0 ? (s + 1.0) / (2.0 * std::numbers::pi) * std::exp(s * std::log1p(-e)) : 0.0;
}

// f is a vMF lobe with kappa 1 / (2 sigma^2). In this form of Torrance-Sparrow, F = V = 1, and k_s includes Fresnel and
// shadowing.
constexpr BrdfMember kTorranceSparrowMembers[] = {kSigma};
constexpr Text kTorranceSparrowFlags[] = {"MULTUM_TORRANCE_SPARROW"},
               kTorranceSparrowFiles[] = {"torrance_sparrow.glsl"};

double kappa_of_sigma(float width) {
  const auto sigma = static_cast<double>(width);
  return 0.5 / (sigma * sigma);
}

double torrance_sparrow_density(float width, double e) {
  const double kappa = kappa_of_sigma(width);
  return kappa / (2.0 * std::numbers::pi * -std::expm1(-2.0 * kappa)) * std::exp(-kappa * e);
}

// Cook and Torrance 1982. f is the same as for Torrance-Sparrow, and V is the shadowing by V-shaped grooves.
constexpr BrdfMember kCookTorranceMembers[] = {kSigma, kF0};
constexpr Text kCookTorranceFlags[] = {"MULTUM_TORRANCE_SPARROW", "MULTUM_COOK_TORRANCE", "MULTUM_VISIBILITY"},
               kCookTorranceFiles[] = {"torrance_sparrow.glsl", "cook_torrance.glsl"};

double groove_visibility(float, double n_l, double n_v, double n_h, double v_h) {
  return 0.25 * std::min(1.0 / std::max(n_l * n_v, 1e-8), 2.0 * n_h / std::max(v_h, 1e-4) / std::max({n_l, n_v, 1e-4}));
}

// GGX as in glTF, with alpha = roughness^2 and Smith's V.
constexpr BrdfMember kGgxMembers[] = {kRoughness, kF0};
constexpr Text kGgxFlags[] = {"MULTUM_GGX", "MULTUM_VISIBILITY"},
               kGgxFiles[] = {"cook_torrance.glsl", "ggx.glsl", "ggx_lobe.glsl"};

double ggx_of_roughness(float width, double e) { return ggx_density(alpha_of(width), e); }

double smith_visibility(float width, double n_l, double n_v, double, double) {
  const double x = std::pow(alpha_of(width), 2.0);
  return 0.5 / std::max(n_l * std::sqrt(n_v * n_v * (1.0 - x) + x) + n_v * std::sqrt(n_l * n_l * (1.0 - x) + x), 1e-6);
}

// Sheen of cloth: Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", with alpha = roughness^2. V is
// the visibility term of Ashikhmin and Premoze 2007, which KHR_materials_sheen, Filament and three.js also use. f is 0
// at the normal.
constexpr BrdfMember kCharlieMembers[] = {kRoughness};
constexpr Text kCharlieFlags[] = {"MULTUM_CHARLIE", "MULTUM_VISIBILITY"}, kCharlieFiles[] = {"charlie.glsl"};

// Density of Charlie: (2 + 1 / alpha) sin^(1 / alpha) / (2 pi).
double charlie_density(float width, double e) {
  const double power = 0.5 / alpha_of(width);
  return e < 1.0 ? (1.0 + power) / std::numbers::pi * std::pow(e * (2.0 - e), power) : 0.0;
}

// Near the horizon, f is about exp(-t^2 / (2 alpha)), where t = n.h.
double charlie_exponent(float width) { return 1.0 / alpha_of(width); }

double sheen_visibility(float, double n_l, double n_v, double, double) {
  return 0.25 / std::max(n_l + n_v - n_l * n_v, 1e-6);
}

// f(n.h) and F(v.h) are read from a file, and V is 1.
constexpr Text kMeasuredFlags[] = {"MULTUM_MEASURED"}, kMeasuredFiles[] = {"measured.glsl", "terms.glsl"};

constexpr Text kLambertFlags[] = {"MULTUM_LAMBERT"};

constexpr BrdfFamily kFamilies[] = {
    {.kind = BrdfKind::kLambert,
     .name = "lambert",
     .specular = 0.0f,
     .fit = BrdfFit::kNone,
     .shader_flags = kLambertFlags},
    {.kind = BrdfKind::kBlinnPhong,
     .name = "blinn-phong",
     .members = kBlinnPhongMembers,
     .fit = BrdfFit::kEqualMean,
     .density = blinn_phong_density,
     .exponent = width_itself,
     .shader_flags = kBlinnPhongFlags,
     .shader_files = kBlinnPhongFiles},
    {.kind = BrdfKind::kTorranceSparrow,
     .name = "torrance-sparrow",
     .members = kTorranceSparrowMembers,
     .fit = BrdfFit::kOne,
     .density = torrance_sparrow_density,
     .exponent = kappa_of_sigma,
     .shader_flags = kTorranceSparrowFlags,
     .shader_files = kTorranceSparrowFiles},
    {.kind = BrdfKind::kCookTorrance,
     .name = "cook-torrance",
     .members = kCookTorranceMembers,
     .specular = 1.0f,  // the measured specular part includes Schlick's term
     .fit = BrdfFit::kOne,
     .density = torrance_sparrow_density,
     .exponent = kappa_of_sigma,
     .visibility = groove_visibility,
     .shader_flags = kCookTorranceFlags,
     .shader_files = kCookTorranceFiles},
    {.kind = BrdfKind::kGgx,
     .name = "ggx",
     .members = kGgxMembers,
     .specular = 1.0f,
     .is_normalised = false,  // it is normalised by projected area
     .density = ggx_of_roughness,
     .visibility = smith_visibility,
     .shader_flags = kGgxFlags,
     .shader_files = kGgxFiles},
    {.kind = BrdfKind::kCharlie,
     .name = "charlie",
     .members = kCharlieMembers,
     .specular = 1.0f,  // glTF's sheenColorFactor
     .sum_from = 0.6,
     .lights_alone = true,
     .is_normalised = false,  // it is normalised by projected area
     .density = charlie_density,
     .exponent = charlie_exponent,
     .visibility = sheen_visibility,
     .shader_flags = kCharlieFlags,
     .shader_files = kCharlieFiles},
    {.kind = BrdfKind::kMeasured,
     .name = "measured",
     .is_file = true,
     .specular = 1.0f,
     .is_normalised = false,
     .shader_flags = kMeasuredFlags,
     .shader_files = kMeasuredFiles,
     .shader_takes_terms = true},
};

// brdf_family() relies on this order.
constexpr bool stand_by_kind() {
  for (std::size_t i = 0; i < std::size(kFamilies); ++i)
    if (kFamilies[i].kind != static_cast<BrdfKind>(i)) return false;
  return true;
}
static_assert(stand_by_kind());

}  // namespace

std::span<const BrdfFamily> brdf_families() { return kFamilies; }

const BrdfFamily& brdf_family(BrdfKind kind) { return kFamilies[static_cast<std::size_t>(kind)]; }

const BrdfFamily* find_brdf_family(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kFamilies), std::end(kFamilies),
                                         [&](const BrdfFamily& family) { return family.name == name; });
  return found == std::end(kFamilies) ? nullptr : found;
}

double ggx_density(double alpha, double e) {
  if (e >= 1.0) return 0.0;
  const double square = alpha * alpha, t = 1.0 - e, y = square * t * t + e * (2.0 - e);
  return square / (std::numbers::pi * y * y);
}

}  // namespace multum
