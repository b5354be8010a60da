// SPDX-License-Identifier: Apache-2.0
#include "host/api/lobe_shading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/formats/brdf/brdf_text.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/fresnel.h"

namespace multum {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAmplitudeMin = 1e-6;  // lobes with a smaller amplitude are ignored
constexpr int kTermCount = 4;
constexpr double kSpreadMin = 1e-7;  // kappa of at most 1e7, so that densities of single directions stay finite

struct Lobe {
  double amplitude = 0.0;
  double spread = 0.0;  // d = 1 - |r|
  glm::dvec3 mean{0.0, 0.0, 1.0};
};

Lobe lobe_of(const float (&stored)[4]) {
  Lobe lobe;
  lobe.amplitude = static_cast<double>(stored[3]);
  if (lobe.amplitude <= kAmplitudeMin) return {};
  const glm::dvec3 r(stored[0], stored[1], stored[2]);
  const double length = glm::length(r);
  lobe.spread = std::clamp((lobe.amplitude - length) / lobe.amplitude, 0.0, 1.0);
  if (length > 1e-12) lobe.mean = r / length;
  return lobe;
}

// Returns kappa for a spread of 1 - A(kappa), like shading_kappa() of kernels/device/vmf_shading.clh.
double kappa_of(double spread) {
  const double mean = 1.0 - spread, x = mean * mean;
  double p = 0.90242 * x - 1.04417;
  p = p * x - 0.12665;
  p = p * x - 0.20753;
  return mean * (3.0 - x + x * (1.0 - x) * p) / std::max(spread * (2.0 - spread), 1e-12);
}

// Returns the density of a vMF at e = 1 - cos.
double vmf(double kappa, double e) {
  const double scale = kappa > 1e-3 ? kappa / -std::expm1(-2.0 * kappa) : 0.5 * (1.0 + kappa);
  return scale / (2.0 * kPi) * std::exp(-kappa * e);
}

double one_minus_cosine(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 difference = a - b;
  return 0.5 * glm::dot(difference, difference);
}

// Returns the mean of max(n . w, 0) over a vMF of this spread. t is the cosine of the angle between the mean direction
// of the vMF and w (vmf_mean_cosine() of kernels/device/vmf_shading.clh).
double mean_cosine(double spread, double t) {
  const double r = 1.0 - spread, m = r * t;
  const double v = spread * (r * (r * 0.15232 + 0.2343) + 0.25);
  const double x = std::min(m * m / std::max(v, 1e-20), 200.0);
  const double g = x * (r * (r * -0.3658 + 0.2857) + 0.4117 + 0.0080 * x);
  return 0.5 * (m + std::sqrt(v * std::exp(-g) + m * m));
}

// Returns the mean of max(n . w, 0) over the product of the lobe and a vMF of concentration `facets` around h.
double highlight_cosine(const Lobe& lobe, const glm::dvec3& h, const glm::dvec3& w, double facets) {
  const double kappa = kappa_of(lobe.spread);
  const glm::dvec3 sum = lobe.mean * kappa + facets * h;
  const double size = glm::length(sum);
  return mean_cosine(lobe.spread > 0.0 ? vmf_spread(size) : 0.0, glm::dot(sum, w) / std::max(size, 1e-6));
}

// The spread of a term of f that is convolved with the lobe.
double convolved(const Lobe& lobe, const VmfTerm& term) { return lobe.spread + (1.0 - lobe.spread) * term.spread; }

// Returns the normalised Blinn-Phong of exponent s convolved with the lobe, at e = 1 - mu . h: a blend of a vMF and a
// cosine power (blinn_phong_lobe() of kernels/device/vmf_shading.clh).
double blinn_phong(const Lobe& lobe, double s, double e) {
  constexpr double kShapeBlend = 1.4;
  const double d = lobe.spread, r = 1.0 - d, q = d + r / (s + 2.0);
  const double power = std::max((1.0 - 2.0 * q) / q, 0.0);
  const double weight = r * r / (kShapeBlend * d * (s + 2.0) + r * r);
  const double wide = vmf(kappa_of(q), e);
  const double narrow = e < 1.0 ? (power + 1.0) / (2.0 * kPi) * std::exp(power * std::log1p(-e)) : 0.0;
  return wide + weight * (narrow - wide);
}

// Returns the lobe of only the normals, like without_roughness() of kernels/device/vmf_shading.clh. `of_roughness` is
// the mean cosine of the roughness that the lobe contains, or 0.
Lobe without_roughness(Lobe lobe, double of_roughness) {
  if (of_roughness > 0.0) lobe.spread = 1.0 - std::min((1.0 - lobe.spread) / of_roughness, 1.0);
  return lobe;
}

// The highlight of a BRDF. If the lobes contain roughness, they are themselves the highlight, as one term without
// width.
struct Highlight {
  Highlight(const multum_lobes& lobes, const multum_brdf& brdf_in) : brdf(brdf_in) {
    of_roughness = static_cast<double>(lobes.mean_cosine);
    is_blinn_phong = of_roughness <= 0.0 && brdf.brdf.kind == BrdfKind::kBlinnPhong;
  }
  const std::vector<VmfTerm>& terms() const {
    static const std::vector<VmfTerm> kMirror = {{glm::dvec3(1.0), 0.0, 0.0}};
    return of_roughness > 0.0 && !brdf.terms.empty() ? kMirror : brdf.terms;
  }
  // Returns the concentration that stands for the facets in a highlight's cosine.
  double facets_of(const VmfTerm& term) const {
    return kappa_of(of_roughness > 0.0 ? 1.0 - of_roughness : term.spread);
  }
  bool has_visibility() const { return of_roughness <= 0.0 && family_of(brdf.brdf).visibility != nullptr; }

  const multum_brdf& brdf;
  double of_roughness;
  bool is_blinn_phong;
};

struct Facets {
  glm::dvec3 density{0.0}, with_light{0.0}, with_view{0.0};  // without a cosine, and multiplied by the cosine to l or v
};

Facets facets_of(const Lobe& lobe, const Highlight& highlight, const glm::dvec3& h, const glm::dvec3& l,
                 const glm::dvec3& v) {
  Facets sum;
  const double e = one_minus_cosine(lobe.mean, h);
  const Lobe of_normals = without_roughness(lobe, highlight.of_roughness);
  for (const VmfTerm& term : highlight.terms()) {
    const double shape = highlight.is_blinn_phong
                             ? blinn_phong(lobe, static_cast<double>(highlight.brdf.brdf.exponent), e)
                             : vmf(kappa_of(std::max(convolved(lobe, term), kSpreadMin)), e);
    const glm::dvec3 density = term.weight * shape;
    const double facets = highlight.facets_of(term);
    sum.density += density;
    sum.with_light += density * highlight_cosine(of_normals, h, l, facets);
    if (highlight.has_visibility()) sum.with_view += density * highlight_cosine(of_normals, h, v, facets);
  }
  for (glm::dvec3* part : {&sum.density, &sum.with_light, &sum.with_view})
    *part = glm::max(*part, glm::dvec3(0.0)) * lobe.amplitude;
  return sum;
}

double total(const glm::dvec3& c) { return c.x + c.y + c.z; }

// V at the mean cosines over the normals of the lobe that reflect light from l to v.
double visibility(const Lobe& lobe, const multum_brdf& brdf, const Facets& facets, const glm::dvec3& h,
                  const glm::dvec3& v) {
  const BrdfFamily& family = family_of(brdf.brdf);
  const double density = std::max(total(facets.density), 1e-20);
  const double n_l = std::clamp(total(facets.with_light) / density, 0.0, 1.0);
  const double n_v = std::clamp(total(facets.with_view) / density, 0.0, 1.0);
  const glm::dvec3 n = lobe.spread * h + lobe.mean / std::max(brdf.exponent, 1e-6);
  const double size = glm::length(n);
  const double n_h = size > 1e-6 ? std::max(glm::dot(n, h), 0.0) / size : 0.0;
  return family.visibility(width_of(brdf.brdf), n_l, n_v, n_h, glm::dot(v, h));
}

glm::dvec3 colour_of(const multum_lobes& lobes, int j, double amplitude) {
  if (lobes.has_colours == 0) return glm::dvec3(1.0);
  const float(&c)[3] = lobes.colours[j];
  return glm::dvec3(c[0], c[1], c[2]) / std::max(amplitude, kAmplitudeMin);
}

// Returns two unit vectors orthogonal to n and to each other (Duff et al. 2017).
std::array<glm::dvec3, 2> orthogonal(const glm::dvec3& n) {
  const double sign = std::copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  return {glm::dvec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), glm::dvec3(b, sign + n.y * n.y * a, -n.y)};
}

glm::dvec3 around(const glm::dvec3& axis, double cosine, double angle) {
  const double sine = std::sqrt(std::max(0.0, (1.0 - cosine) * (1.0 + cosine)));
  const auto [s, t] = orthogonal(axis);
  return glm::normalize(s * (sine * std::cos(angle)) + t * (sine * std::sin(angle)) + axis * cosine);
}

// Draws a direction from a vMF by inverting its distribution (Ulrich 1984; Jakob 2012 for the stable form).
glm::dvec3 draw_vmf(const glm::dvec3& mean, double kappa, double u, double angle) {
  const double cosine = kappa > 1e-6 ? 1.0 + std::log(u + (1.0 - u) * std::exp(-2.0 * kappa)) / kappa : 2.0 * u - 1.0;
  return around(mean, std::clamp(cosine, -1.0, 1.0), angle);
}

// A sampling technique. It is one term of f convolved with one lobe, or the diffuse light of one lobe.
struct Technique {
  double weight;  // probability
  glm::dvec3 axis;
  double kappa;  // if negative, directions are distributed by the cosine around the axis
};

constexpr int kTechniquesMax = MULTUM_LOBES_MAX * (kBrdfTermCountMax + 1);

struct Techniques {
  std::array<Technique, kTechniquesMax> all;
  int count = 0;
};

// The weights are estimates of the reflected light. For a highlight, this is k_s F times the weight of the term, with F
// at the reflection by the lobe itself. The other weight is that of the diffuse part.
Techniques techniques_of(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& v) {
  Techniques found;
  const Highlight highlight(lobes, brdf);
  double sum = 0.0;
  const auto add = [&](double weight, const glm::dvec3& axis, double kappa) {
    if (!(weight > 0.0)) return;
    found.all[static_cast<std::size_t>(found.count++)] = {weight, axis, kappa};
    sum += weight;
  };
  for (int j = 0; j < std::min(lobes.count, MULTUM_LOBES_MAX); ++j) {
    const Lobe lobe = lobe_of(lobes.lobes[j]);
    if (lobe.amplitude <= kAmplitudeMin) continue;
    const glm::dvec3 f = fresnel(brdf.brdf, std::clamp(glm::dot(v, lobe.mean), 0.0, 1.0));
    for (const VmfTerm& term : highlight.terms())
      add(lobe.amplitude * total(glm::dvec3(brdf.brdf.specular) * f * glm::abs(term.weight)), lobe.mean,
          kappa_of(std::max(convolved(lobe, term), kSpreadMin)));
    const glm::dvec3 albedo =
        lobes.has_colours != 0 ? colour_of(lobes, j, lobe.amplitude) : glm::dvec3(brdf.brdf.diffuse);
    add(lobe.amplitude * total(albedo), lobe.mean, -1.0);
  }
  for (int i = 0; i < found.count; ++i) found.all[static_cast<std::size_t>(i)].weight /= sum;
  return found;
}

double pdf_of(const Techniques& techniques, const glm::dvec3& v, const glm::dvec3& l) {
  const glm::dvec3 sum = l + v;
  const double size = glm::length(sum);
  const glm::dvec3 h = size > 1e-9 ? sum / size : v;
  const double v_h = std::abs(glm::dot(v, h));
  double pdf = 0.0;
  for (int i = 0; i < techniques.count; ++i) {
    const Technique& one = techniques.all[static_cast<std::size_t>(i)];
    // The half vectors h and -h reflect v to the same l.
    const auto of_half = [&] {
      const double e = one_minus_cosine(one.axis, h);
      return (vmf(one.kappa, e) + vmf(one.kappa, 2.0 - e)) / std::max(4.0 * v_h, 1e-9);
    };
    pdf += one.weight * (one.kappa < 0.0 ? std::max(glm::dot(l, one.axis), 0.0) / kPi : of_half());
  }
  return pdf;
}

}  // namespace

multum_brdf shaded_brdf(const std::string& text) {
  multum_brdf made;
  made.brdf = parse_brdf("brdf", text, kTermCount);
  if (has_highlight(made.brdf)) made.terms = vmf_terms(made.brdf);
  if (has_highlight(made.brdf)) made.exponent = equivalent_exponent(made.brdf);
  return made;
}

glm::dvec3 shade_lobes(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& l, const glm::dvec3& v) {
  if (l.z <= 0.0 || v.z <= 0.0) return glm::dvec3(0.0);
  const glm::dvec3 h = glm::normalize(l + v);
  const double v_h = std::max(glm::dot(v, h), 0.0);
  const Highlight highlight(lobes, brdf);
  const glm::dvec3 f = fresnel(brdf.brdf, v_h);
  glm::dvec3 diffuse(0.0), specular(0.0);
  for (int j = 0; j < std::min(lobes.count, MULTUM_LOBES_MAX); ++j) {
    const Lobe lobe = lobe_of(lobes.lobes[j]);
    if (lobe.amplitude <= kAmplitudeMin) continue;
    const double spread = without_roughness(lobe, highlight.of_roughness).spread;
    diffuse += colour_of(lobes, j, lobe.amplitude) *
               (lobe.amplitude * mean_cosine(spread, 1.0 - one_minus_cosine(lobe.mean, l)));
    const Facets facets = facets_of(lobe, highlight, h, l, v);
    specular += facets.with_light * (highlight.has_visibility() ? visibility(lobe, brdf, facets, h, v) : 1.0);
  }
  glm::dvec3 albedo = lobes.has_colours != 0 ? glm::dvec3(1.0) : glm::dvec3(brdf.brdf.diffuse);
  if (has_diffuse_fresnel(brdf.brdf)) albedo *= glm::dvec3(1.0) - f;
  return albedo * diffuse / kPi + glm::dvec3(brdf.brdf.specular) * f * specular;
}

double lobe_density(const multum_lobes& lobes, const glm::dvec3& n) {
  double sum = 0.0;
  for (int j = 0; j < std::min(lobes.count, MULTUM_LOBES_MAX); ++j) {
    const Lobe lobe = lobe_of(lobes.lobes[j]);
    if (lobe.amplitude > kAmplitudeMin)
      sum += lobe.amplitude * vmf(kappa_of(std::max(lobe.spread, kSpreadMin)), one_minus_cosine(lobe.mean, n));
  }
  return sum;
}

double sample_lobes(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& v, const glm::dvec3& random,
                    glm::dvec3& l) {
  const Techniques techniques = techniques_of(lobes, brdf, v);
  if (techniques.count == 0) return 0.0;
  double rest = random.x;
  int chosen = 0;
  while (chosen + 1 < techniques.count && rest >= techniques.all[static_cast<std::size_t>(chosen)].weight)
    rest -= techniques.all[static_cast<std::size_t>(chosen++)].weight;
  const Technique& one = techniques.all[static_cast<std::size_t>(chosen)];
  const double angle = 2.0 * kPi * random.z;
  if (one.kappa < 0.0) {
    l = around(one.axis, std::sqrt(random.y), angle);
  } else {
    const glm::dvec3 h = draw_vmf(one.axis, one.kappa, 1.0 - random.y, angle);
    l = glm::normalize(2.0 * glm::dot(v, h) * h - v);
  }
  return pdf_of(techniques, v, l);
}

double lobe_pdf(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& v, const glm::dvec3& l) {
  return pdf_of(techniques_of(lobes, brdf, v), v, l);
}

}  // namespace multum
