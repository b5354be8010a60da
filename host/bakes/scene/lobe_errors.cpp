// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/lobe_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <utility>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/movmf_start.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/foundation/base/mean_cosine.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr int kDirections = 32;
constexpr int kIterations = 15;
constexpr double kKappaMax = 1e6;
constexpr double kCapInEm = 5e3, kCapAtTop = 500.0;
constexpr double kStartKappaFactor = 0.5, kStartAmplitudeMin = 0.02;  // values of MovmfSettings
constexpr double kSingleDirection = 1e-7;                             // 1 - |r| of equal normals in single precision

double density(double kappa, double t) { return kappa / (1.0 - std::exp(-2.0 * kappa)) * std::exp(kappa * (t - 1.0)); }

// Shades one normal, which may be shortened by a BRDF's width.
double shade_normal(const glm::dvec3& n, const ShadedBy& by, const glm::dvec3& w) {
  const double length = glm::length(n), t = glm::dot(n, w) / length;
  if (!by.exponent) return std::max(t, 0.0);
  const double width = 1.0 - 1.0 / *by.exponent;
  return density(kappa_of_mean_cosine(length > 1.0 - 1e-6 ? width : length * width, kKappaMax), t);
}

// Shades a lobe, because mean cosines multiply under convolution (docs/contributing/ALGORITHMS.md, "Shading a filtered
// lobe").
double shade_lobe(const MixtureLobe& lobe, const ShadedBy& by, double mean_cosine, const glm::dvec3& w) {
  if (!by.exponent) return lobe_lambert(std::min(lobe.mean_length / mean_cosine, 1.0) * lobe.mu, w);
  return density(kappa_of_mean_cosine(lobe.mean_length * (1.0 - 1.0 / *by.exponent), kKappaMax), glm::dot(lobe.mu, w));
}

// Shades a planar Gaussian (Tan et al. 2005) as runtime_gl/shaders/common/gmm_shading.glsl does, in the unit of
// shade_normal(). `planar` holds E[x], E[y] and E[x^2 + y^2].
double shade_gaussian(const glm::dvec3& planar, const ShadedBy& by, const glm::dvec3& w) {
  const double square = planar.x * planar.x + planar.y * planar.y;
  const glm::dvec3 lifted(planar.x, planar.y, std::sqrt(std::max(1.0 - square, 0.0)));
  if (!by.exponent) return std::max(glm::dot(lifted, w), 0.0);
  const double facets = (1.0 - 0.5 * std::min(square, 1.0)) / (*by.exponent + 3.0);
  const double variance = std::max(0.5 * (planar.z - square), 0.0) + facets, x = w.x - planar.x, y = w.y - planar.y;
  return std::exp(-0.5 * (x * x + y * y) / variance) / variance * std::max(w.z, 0.0);
}

// Returns the weight of a normal.
double weight_of(const std::vector<glm::dvec4>& weights, std::size_t i, const ShadedBy& by) {
  return by.weight < 0 || weights.empty() ? 1.0 : weights[i][by.weight];
}

glm::dvec3 mean_colour(const SurveyedTexel& texel, ColourModel colours) {
  if (colours == ColourModel::kNone || texel.colours.empty()) return glm::dvec3(1.0);
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& colour : texel.colours) mean += colour / static_cast<double>(texel.colours.size());
  return mean;
}

// Returns the exponent of the sharpest highlight that a texel's normals resolve. The normals may be a sample. The width
// of this highlight would contain several normals if they were spread evenly over all directions within acos |mean|.
double resolved_exponent(const MapSurvey& survey, const SurveyedTexel& texel) {
  constexpr double kWithin = 4.0;
  const auto count = static_cast<double>(texel.normals.size());
  const double texels = static_cast<double>(survey.width) * survey.height / mip_level_size(survey.width, texel.level) /
                        mip_level_size(survey.height, texel.level);
  if (count > 0.9 * texels) return kEstimatedExponentMax;
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& n : texel.normals) mean += n / count;
  return std::clamp(count / (2.0 * kWithin * std::max(1.0 - glm::length(mean), 1e-6)), 1.0, kEstimatedExponentMax);
}

struct ErrorSums {
  double difference = 0.0, reference = 0.0;
};

}  // namespace

double lobe_lambert(const glm::dvec3& mean, const glm::dvec3& light) {
  const double r = std::min(glm::length(mean), 1.0), d = 1.0 - r;
  const double m = glm::dot(mean, light);
  const double v = d * (0.25 + r * (0.2343 + r * 0.15232));
  const double x = std::min(m * m / std::max(v, 1e-20), 200.0);
  const double g = x * (0.4117 + r * (0.2857 - r * 0.3658) + 0.0080 * x);
  return 0.5 * (m + std::sqrt(m * m + v * std::exp(-g)));
}

LobeErrors::LobeErrors(const MapSurvey& survey, const LobeErrorSettings& settings)
    : survey_(survey),
      settings_(settings),
      copies_(settings.has_roughness ? static_cast<double>(kCopiesShortened) : 1.0) {
  for (const SurveyedTexel& texel : survey.texels) exponent_max_.push_back(resolved_exponent(survey, texel));
}

std::vector<MixtureLobe> LobeErrors::fit_top(int lobe_count) const {
  constexpr int kTrials = 48;
  const Normals& normals = survey_.texels.back().normals;
  std::vector<MixtureFit> fits(kTrials);
  for_each_item(kTrials, settings_.threads, [&](int trial) {
    std::vector<std::size_t> chosen;
    for (int j = 0; j < lobe_count; ++j)
      chosen.push_back(split_mix(static_cast<std::uint64_t>(trial * 8 + j)) % normals.size());
    if (trial == 0) chosen = farthest_first_normals(normals, lobe_count);
    MixtureFit& fit = fits[static_cast<std::size_t>(trial)];
    fit = start_mixture(normals, chosen, settings_.has_roughness);
    iterate_mixture(fit, normals, kIterations, kCapAtTop, copies_);
  });
  return std::max_element(fits.begin(), fits.end(),
                          [](const MixtureFit& a, const MixtureFit& b) { return a.log_likelihood < b.log_likelihood; })
      ->lobes;
}

// Fits a texel in the same way as the bake. The start consists of the coarser texel's lobes, broadened and with a
// minimum amplitude, or of normals that are far apart if these lead to a better fit.
LobeErrors::TexelFit LobeErrors::fit(const SurveyedTexel& texel, int lobe_count,
                                     const std::vector<MixtureLobe>& top) const {
  const Normals& normals = texel.normals;
  const auto count = static_cast<double>(normals.size());
  TexelFit out;
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& n : normals) mean += n / count;
  const double length = glm::length(mean);
  if (lobe_count <= 1 || length < 1e-9) {
    const glm::dvec3 mu = length > 1e-9 ? mean / length : glm::dvec3(0.0, 0.0, 1.0);
    out.lobes = {{mu, lobe_count == 0 ? 1.0 : std::min(length, 1.0), 1.0, 1.0}};
  } else {
    const int lobes = std::min(lobe_count, static_cast<int>(normals.size()));
    MixtureFit mixture = start_mixture(normals, farthest_first_normals(normals, lobes), settings_.has_roughness);
    MixtureFit inherited{top, 0.0, 0.0};
    for (MixtureLobe& lobe : inherited.lobes) {
      lobe.kappa *= kStartKappaFactor;
      lobe.amplitude = std::max(lobe.amplitude, kStartAmplitudeMin);
    }
    for (MixtureFit* one : {&mixture, &inherited}) iterate_mixture(*one, normals, kIterations, kCapInEm, copies_);
    if (inherited.log_likelihood > mixture.log_likelihood) mixture = inherited;
    out.lobes = mixture.lobes;
  }
  add_means(texel, out);
  return out;
}

void LobeErrors::add_means(const SurveyedTexel& texel, TexelFit& fit) const {
  const Normals& normals = texel.normals;
  const std::size_t lobe_count = fit.lobes.size();
  const bool has_colours = !texel.colours.empty(), has_weights = !texel.weights.empty();
  for (const glm::dvec3& colour : texel.colours) fit.mean_colour += colour / static_cast<double>(normals.size());
  std::vector<double> totals(lobe_count, 0.0);
  fit.planar.assign(lobe_count, glm::dvec3(0.0));
  if (has_colours) fit.colours.assign(lobe_count, glm::dvec3(0.0));
  if (has_weights) fit.weights.assign(lobe_count, glm::dvec4(0.0));
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const glm::dvec3& n = normals[i];
    std::array<double, 8> share{};
    double total = 0.0, largest = -HUGE_VAL;
    for (std::size_t j = 0; j < lobe_count; ++j) {
      const MixtureLobe& lobe = fit.lobes[j];
      const double kappa = kappa_of_mean_cosine(lobe.mean_length, kCapInEm);
      share[j] = std::log(std::max(lobe.amplitude, 1e-300)) +
                 copies_ * (std::log(kappa / (1.0 - std::exp(-2.0 * kappa))) + kappa * (glm::dot(lobe.mu, n) - 1.0));
      largest = std::max(largest, share[j]);
    }
    for (std::size_t j = 0; j < lobe_count; ++j) total += share[j] = std::exp(share[j] - largest);
    for (std::size_t j = 0; j < lobe_count; ++j) {
      const double part = share[j] / total;
      totals[j] += part;
      fit.planar[j] += part * glm::dvec3(n.x, n.y, n.x * n.x + n.y * n.y);
      if (has_colours) fit.colours[j] += part * texel.colours[i];
      if (has_weights) fit.weights[j] += part * texel.weights[i];
    }
    if (!has_colours) continue;
    const glm::dvec3 off = texel.colours[i] - fit.mean_colour;
    fit.colour_within += glm::dot(off, off);
  }
  for (std::size_t j = 0; j < lobe_count; ++j) {
    const bool occurs = totals[j] > 1e-9;
    if (occurs) fit.planar[j] /= totals[j];
    if (has_weights && occurs) fit.weights[j] /= totals[j];
    if (!has_colours) continue;
    fit.colours[j] = occurs ? fit.colours[j] / totals[j] : fit.mean_colour;
    const glm::dvec3 off = fit.colours[j] - fit.mean_colour;
    fit.colour_between += totals[j] * glm::dot(off, off);
  }
}

const std::vector<LobeErrors::TexelFit>& LobeErrors::fits(int lobe_count) {
  const auto index = static_cast<std::size_t>(lobe_count);
  if (fits_.size() <= index) fits_.resize(index + 1);
  if (!fits_[index].empty()) return fits_[index];
  fits_[index].resize(survey_.texels.size());
  const std::vector<MixtureLobe> top =
      lobe_count > 1 && !survey_.texels.empty() ? fit_top(lobe_count) : std::vector<MixtureLobe>{};
  for_each_item(static_cast<int>(survey_.texels.size()), settings_.threads, [&](int i) {
    const auto t = static_cast<std::size_t>(i);
    if (survey_.texels[t].level >= settings_.first_level) fits_[index][t] = fit(survey_.texels[t], lobe_count, top);
  });
  return fits_[index];
}

double LobeErrors::error_of(const Model& model, const std::vector<ShadedBy>& given, ColourModel colours) const {
  static const std::vector<glm::dvec3> directions = spread_half_vectors(kDirections);
  std::vector<std::vector<ErrorSums>> sums(survey_.texels.size(), std::vector<ErrorSums>(given.size()));
  for_each_item(static_cast<int>(survey_.texels.size()), settings_.threads, [&](int i) {
    const auto t = static_cast<std::size_t>(i);
    const SurveyedTexel& texel = survey_.texels[t];
    if (texel.level < settings_.first_level) return;
    const bool coloured = colours != ColourModel::kNone && !texel.colours.empty();
    std::vector<ShadedBy> shadings = given;
    for (ShadedBy& by : shadings)
      if (by.exponent && std::isfinite(*by.exponent)) by.exponent = std::min(*by.exponent, exponent_max_[t]);
    for (std::size_t s = 0; s < shadings.size(); ++s)
      for (const glm::dvec3& w : directions) {
        glm::dvec3 reference(0.0);
        for (std::size_t n = 0; n < texel.normals.size(); ++n)
          reference += shade_normal(texel.normals[n], shadings[s], w) * weight_of(texel.weights, n, shadings[s]) *
                       (coloured ? texel.colours[n] : glm::dvec3(1.0));
        reference /= static_cast<double>(texel.normals.size());
        const glm::dvec3 off = glm::abs(model(t, shadings[s], w) - reference);
        sums[t][s].difference += off.x + off.y + off.z;
        sums[t][s].reference += reference.x + reference.y + reference.z;
      }
  });
  double worst = 0.0;
  for (std::size_t s = 0; s < given.size(); ++s) {
    std::map<int, ErrorSums> levels;
    for (std::size_t t = 0; t < sums.size(); ++t) {
      if (survey_.texels[t].level < settings_.first_level) continue;
      ErrorSums& level = levels[survey_.texels[t].level];
      level.difference += sums[t][s].difference;
      level.reference += sums[t][s].reference;
    }
    double of_levels = 0.0;
    for (const auto& [level, sum] : levels)
      if (sum.reference > 0.0) of_levels += sum.difference / sum.reference / static_cast<double>(levels.size());
    worst = std::max(worst, of_levels);
  }
  return worst;
}

double LobeErrors::error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours) {
  return lobes_error(lobe_count, false, shadings, colours);
}

double LobeErrors::gmm_error(int lobe_count, const std::vector<ShadedBy>& shadings, ColourModel colours) {
  return lobes_error(lobe_count, true, shadings, colours);
}

double LobeErrors::lobes_error(int lobe_count, bool planar, const std::vector<ShadedBy>& shadings,
                               ColourModel colours) {
  const std::vector<TexelFit>& fitted = fits(lobe_count);
  return error_of(
      [&](std::size_t t, const ShadedBy& by, const glm::dvec3& w) {
        const TexelFit& fit = fitted[t];
        const bool coloured = colours != ColourModel::kNone && !fit.colours.empty();
        glm::dvec3 sum(0.0);
        for (std::size_t j = 0; j < fit.lobes.size(); ++j)
          sum +=
              fit.lobes[j].amplitude * weight_of(fit.weights, j, by) *
              (planar ? shade_gaussian(fit.planar[j], by, w) : shade_lobe(fit.lobes[j], by, settings_.mean_cosine, w)) *
              (!coloured                        ? glm::dvec3(1.0)
               : colours == ColourModel::kLobes ? fit.colours[j]
                                                : fit.mean_colour);
        return sum;
      },
      shadings, colours);
}

double LobeErrors::sh_error(int order, const std::vector<ShadedBy>& shadings, ColourModel colours) const {
  // By the addition theorem, the sum over m of band l is the mean of (2l + 1)/4 pi P_l(n . w).
  return error_of(
      [&](std::size_t t, const ShadedBy& by, const glm::dvec3& w) {
        const Normals& normals = survey_.texels[t].normals;
        const ZonalCoefficients zonal = by.exponent ? zonal_blinn_phong(order, *by.exponent) : zonal_lambert(order);
        // Converts a density to the unit of shade_normal(), 1/2 pi.
        const double unit = by.exponent ? 2.0 * std::numbers::pi : 1.0;
        double sum = 0.0;
        for (const glm::dvec3& n : normals) {
          const double x = glm::dot(n, w);
          double before = 0.0, p = 1.0;
          for (int l = 0; l <= order; ++l) {
            sum += zonal[static_cast<std::size_t>(l)] * (2 * l + 1) / (4.0 * std::numbers::pi) * p;
            before = std::exchange(p, ((2 * l + 1) * x * p - l * before) / (l + 1));
          }
        }
        const double value = unit * std::max(sum / static_cast<double>(normals.size()), 0.0);
        return value * mean_colour(survey_.texels[t], colours);
      },
      shadings, colours);
}

double LobeErrors::lean_error(const std::vector<ShadedBy>& shadings, ColourModel colours) const {
  return error_of(
      [&](std::size_t t, const ShadedBy& by, const glm::dvec3& w) {
        const Normals& normals = survey_.texels[t].normals;
        const auto count = static_cast<double>(normals.size());
        glm::dvec3 mean(0.0);
        double s = 0.0, u = 0.0, ss = 0.0, uu = 0.0, su = 0.0;
        for (const glm::dvec3& n : normals) {
          const double z = std::max(n.z, static_cast<double>(kSlopeZMin)), x = -n.x / z, y = -n.y / z;
          mean += n / count;
          s += x / count, u += y / count;
          ss += x * x / count, uu += y * y / count, su += x * y / count;
        }
        const glm::dvec3 colour = mean_colour(survey_.texels[t], colours);
        if (!by.exponent) return std::max(glm::dot(mean, w), 0.0) * colour;
        if (w.z <= 1e-4) return glm::dvec3(0.0);
        const double base = 1.0 / *by.exponent, a = ss - s * s + base, c = uu - u * u + base, b = su - s * u;
        const double x = -w.x / w.z - s, y = -w.y / w.z - u, determinant = a * c - b * b;
        const double distance = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant;
        // Converts a density to the unit of shade_normal(), 1/2 pi.
        return std::exp(-0.5 * distance) / std::sqrt(determinant) / (w.z * w.z * w.z) * colour;
      },
      shadings, colours);
}

double LobeErrors::colour_correlation(int lobe_count) {
  double within = 0.0, between = 0.0;
  const std::vector<TexelFit>& fitted = fits(lobe_count);
  for (std::size_t t = 0; t < fitted.size(); ++t) {
    const auto count = static_cast<double>(survey_.texels[t].normals.size());
    const auto lobes = static_cast<double>(fitted[t].lobes.size());
    if (count < 8.0 * std::max(lobes, 1.0))
      continue;  // if there are few normals per lobe, lobes explain all of the
                 // variance
    // If colours are independent of lobes, a share (lobes - 1) / (count - 1) of the variance is between lobes by
    // chance.
    within += fitted[t].colour_within;
    between += fitted[t].colour_between - fitted[t].colour_within * (lobes - 1.0) / (count - 1.0);
  }
  return within > 0.0 ? std::clamp(between / within, 0.0, 1.0) : 0.0;
}

double LobeErrors::share_sharper(int lobe_count, double kappa) {
  double sharper = 0.0, all = 0.0;
  for (const TexelFit& fit : fits(lobe_count))
    for (const MixtureLobe& lobe : fit.lobes) {
      const double spread = 1.0 - lobe.mean_length;
      all += lobe.amplitude;
      if (spread > kSingleDirection && spread < 1.0 / kappa) sharper += lobe.amplitude;
    }
  return all > 0.0 ? sharper / all : 0.0;
}

}  // namespace multum
