// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt on the logarithms of the kappas. The weights are optimal for given kappas, and may be negative
// (variable projection: Golub and Pereyra 1973). Minimizes the sum over e of (sum_i w_i vMF_i - f)^2 / f, weighted by
// solid angle. This relative error covers the peak and the tail of GGX, is close to relative L1, and is smooth.
//
// Below the horizon of h, f is 0, but a vMF is greater than 0. In that region, the squared error is divided by
// f(horizon) and multiplied by kHorizonWeight. Without this term, broad vMFs fill the rim of the hemisphere well, but
// extend below the horizon and become visible under a lobe of kappa 3. A larger weight increases the error at the rim.
// The largest relative L1 error over GGX with alpha 0.05 to 0.4, kappa 3 to 2000 and four terms is 2.9 % for weight
// 0.1, 3.2 % for weight 0.3, and 5.9 % for weight 1.
#include "host/formats/brdf/vmf_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "host/formats/brdf/facet_distribution.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr double kHorizonWeight = 0.1;
constexpr double kKappaMin = 0.05;  // almost uniform over directions
constexpr double kKappaMax = 1e7;
constexpr int kRoundCountMax = 80;
constexpr int kWidenCount = 4;
constexpr double kRidge = 1e-6;  // penalty factor for the squared weights, which avoids large terms of opposite signs
constexpr std::array kLadderRatios = {0.2, 0.07};

// A point where f is compared. `value` is f, and `scale` is 1 / tolerance. Samples are evenly spaced in log e above the
// horizon, and in e below the horizon.
struct Sample {
  double e, value, scale;
  double angle;  // solid angle, multiplied by kHorizonWeight below the horizon
};

constexpr int kUpperCount = 240, kLowerCount = 24, kCountMax = kBrdfTermCountMax;
constexpr double kLeast = 1e-8;

// The nodes end just above the horizon, because densities of a hemisphere end there.
double node(int i) {
  return (1.0 - 1e-9) * std::exp(std::log(kLeast) * (1.0 - static_cast<double>(i) / (kUpperCount - 1)));
}

// `value(i)` returns f at upper node i.
template <typename Value>
std::vector<Sample> make_samples(const Value& value) {
  std::vector<Sample> samples;
  const double step = -std::log(kLeast) / (kUpperCount - 1);
  double largest = 0.0;
  for (int i = 0; i < kUpperCount; ++i) largest = std::max(largest, value(i));
  for (int i = 0; i < kUpperCount; ++i) {
    const double e = node(i), f = value(i);
    const double angle = 2.0 * std::numbers::pi * e * step;
    samples.push_back({e, f, std::sqrt(angle / std::max(f, 1e-6 * largest)), angle});
  }
  const double horizon = std::max(samples.back().value, 1e-6 * largest);
  const double angle = kHorizonWeight * 2.0 * std::numbers::pi / kLowerCount;
  for (int i = 0; i < kLowerCount; ++i)
    samples.push_back({1.0 + (i + 0.5) / kLowerCount, 0.0, std::sqrt(angle / horizon), angle});
  return samples;
}

double unit_vmf(double kappa, double e) {
  return kappa / (2.0 * std::numbers::pi * -std::expm1(-2.0 * kappa)) * std::exp(-kappa * e);
}

// Returns the vMFs of the terms, times the scale of the sample, at index [sample * terms + i].
std::vector<double> scaled_terms(const std::vector<Sample>& samples, const std::vector<double>& kappas) {
  std::vector<double> rows;
  rows.reserve(samples.size() * kappas.size());
  for (const Sample& s : samples)
    for (const double kappa : kappas) rows.push_back(unit_vmf(kappa, s.e) * s.scale);
  return rows;
}

using Vector = std::array<double, kCountMax>;
using Matrix = std::array<Vector, kCountMax>;

// Solves a symmetric positive system with `n` unknowns by Gaussian elimination.
Vector solve(Matrix a, Vector b, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  Vector x{};
  for (std::size_t k = n; k-- > 0;) {
    double sum = b[k];
    for (std::size_t j = k + 1; j < n; ++j) sum -= a[k][j] * x[j];
    x[k] = sum / a[k][k];
  }
  return x;
}

// Returns the best weights for fixed kappas. Weights may be negative, because a density that ends at the horizon, or
// rises towards it, is the difference of two broad vMFs.
Vector fit_weights(const std::vector<Sample>& samples, const std::vector<double>& rows, std::size_t n) {
  Matrix gram{};
  Vector right{};
  for (std::size_t k = 0; k < samples.size(); ++k)
    for (std::size_t i = 0; i < n; ++i) {
      const double row = rows[k * n + i];
      right[i] += row * samples[k].value * samples[k].scale;
      for (std::size_t j = 0; j < n; ++j) gram[i][j] += row * rows[k * n + j];
    }
  for (std::size_t i = 0; i < n; ++i) gram[i][i] *= 1.0 + kRidge;
  return solve(gram, right, n);
}

// One density, or one channel of a density.
struct Fitted {
  std::vector<Sample> samples;
  Vector weights;
  std::vector<double> residuals;
};

// Fits the weights of each channel to these kappas. Returns the sum of squares.
double fit_all(std::vector<Fitted>& channels, const std::vector<double>& kappas) {
  const std::size_t n = kappas.size();
  double sum = 0.0;
  for (Fitted& one : channels) {
    const std::vector<double> rows = scaled_terms(one.samples, kappas);
    one.weights = fit_weights(one.samples, rows, n);
    one.residuals.clear();
    for (std::size_t k = 0; k < one.samples.size(); ++k) {
      double residual = -one.samples[k].value * one.samples[k].scale;
      for (std::size_t i = 0; i < n; ++i) residual += one.weights[i] * rows[k * n + i];
      one.residuals.push_back(residual);
      sum += residual * residual;
    }
  }
  return sum;
}

// If f is smaller than the error of the fit, this error is used as the tolerance. Some measured densities end at an
// angle. Without this rule, the region beyond this angle would dominate the fit.
void widen(Fitted& one) {
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    Sample& s = one.samples[k];
    const double off = std::abs(one.residuals[k]) / s.scale;
    if (s.e < 1.0 && off > s.value) s.scale = std::min(s.scale, std::sqrt(s.angle / off));
  }
}

double step_kappa(double kappa, double log_step) {
  return std::clamp(kappa * std::exp(std::clamp(log_step, -1.0, 1.0)), kKappaMin, kKappaMax);
}

// Variable projection: the weights follow from the kappas, so Levenberg-Marquardt varies only the kappas. Leaves the
// best weights in `channels`, and returns the sum of squares.
double fit_kappas(std::vector<Fitted>& channels, std::vector<double>& kappas) {
  constexpr double kDifference = 1e-4;  // difference of log kappa
  const std::size_t n = kappas.size();
  double best = fit_all(channels, kappas), damping = 1e-2;
  for (int round = 0; round < kRoundCountMax; ++round) {
    std::vector<std::vector<double>> slopes(n);
    const std::vector<Fitted> here = channels;
    for (std::size_t i = 0; i < n; ++i) {
      std::vector<double> moved = kappas;
      moved[i] *= std::exp(kDifference);
      fit_all(channels, moved);
      for (std::size_t c = 0; c < here.size(); ++c)
        for (std::size_t k = 0; k < here[c].residuals.size(); ++k)
          slopes[i].push_back((channels[c].residuals[k] - here[c].residuals[k]) / kDifference);
    }
    Matrix normal{};
    Vector right{};
    std::size_t row = 0;
    for (const Fitted& one : here)
      for (const double residual : one.residuals) {
        for (std::size_t i = 0; i < n; ++i) {
          right[i] -= slopes[i][row] * residual;
          for (std::size_t j = 0; j < n; ++j) normal[i][j] += slopes[i][row] * slopes[j][row];
        }
        ++row;
      }
    double trace = 0.0;
    for (std::size_t i = 0; i < n; ++i) trace += normal[i][i];
    bool improved = false, finished = true;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      Matrix damped = normal;
      for (std::size_t i = 0; i < n; ++i) damped[i][i] += damping * (normal[i][i] + 1e-9 * trace) + 1e-300;
      const Vector step = solve(damped, right, n);
      std::vector<double> next = kappas;
      for (std::size_t i = 0; i < n; ++i) next[i] = step_kappa(kappas[i], step[i]);
      const double tried = fit_all(channels, next);
      improved = tried < best;
      damping *= improved ? 0.3 : 4.0;
      if (!improved) continue;
      finished = best - tried < 1e-7 * best;
      best = tried;
      kappas = next;
    }
    if (finished) break;
  }
  return fit_all(channels, kappas);
}

// Returns the relative L1 error over solid angle, summed over the channels. This error can be used to compare fits that
// have different tolerances.
double relative_difference(const std::vector<Fitted>& channels) {
  double sum = 0.0;
  for (const Fitted& one : channels) {
    double off = 0.0, total = 0.0;
    for (std::size_t k = 0; k < one.samples.size(); ++k) {
      off += std::abs(one.residuals[k]) / one.samples[k].scale * one.samples[k].angle;
      total += one.samples[k].value * one.samples[k].angle;
    }
    sum += off / total;
  }
  return sum;
}

// Returns starting kappas near the kappa of the peak. Each kappa is `ratio` times the previous one. A density with f(0)
// = 0, such as a sheen, has no peak, and differences of broad terms approximate its rise.
std::vector<double> ladder(const std::vector<Sample>& samples, int count, double ratio) {
  double total = 0.0;
  for (const Sample& s : samples) total += s.value * s.value * s.scale * s.scale;  // integral of f
  const double peak = 2.0 * std::numbers::pi * samples[0].value / total;
  double largest = 0.0;
  for (const Sample& s : samples) largest = std::max(largest, s.value);
  const bool has_peak = samples[0].value > 1e-3 * largest;
  std::vector<double> kappas;
  for (int i = 0; i < count; ++i)
    kappas.push_back(
        has_peak ? std::clamp((count == 1 ? 0.7 : 1.7) * peak * std::pow(ratio, i), 0.1 * std::pow(1.5, -i), kKappaMax)
                 : 20.0 * ratio * std::pow(0.5, i));
  return kappas;
}

}  // namespace

double vmf_spread(double kappa) {
  if (kappa < 0.1) return 1.0 - kappa / 3.0 + kappa * kappa * kappa / 45.0;
  return 1.0 / kappa - 2.0 / std::expm1(2.0 * std::min(kappa, 300.0));
}

double vmf_kappa(double spread) {
  double low = 1e-6, high = 1e9;
  for (int i = 0; i < 80; ++i) {
    const double middle = std::sqrt(low * high);
    (vmf_spread(middle) > spread ? low : high) = middle;
  }
  return low;
}

std::vector<VmfTerm> fit_vmf_terms(const std::function<glm::dvec3(double)>& density, int count) {
  MULTUM_CHECK(count >= 1 && count <= kBrdfTermCountMax);
  std::vector<glm::dvec3> values;
  for (int i = 0; i < kUpperCount; ++i) values.push_back(density(node(i)));
  const bool is_grey =
      std::all_of(values.begin(), values.end(), [](const glm::dvec3& v) { return v.x == v.y && v.y == v.z; });
  std::vector<Fitted> first(is_grey ? 1 : 3);
  for (std::size_t c = 0; c < first.size(); ++c)
    first[c].samples = make_samples([&](int i) { return values[static_cast<std::size_t>(i)][static_cast<int>(c)]; });
  std::vector<Fitted> best;
  std::vector<double> kappas;
  double least = std::numeric_limits<double>::infinity();
  for (const double ratio : kLadderRatios) {
    std::vector<Fitted> channels = first;
    std::vector<double> tried = ladder(first[0].samples, count, ratio);
    fit_kappas(channels, tried);
    for (int round = 0; round < kWidenCount; ++round) {
      for (Fitted& one : channels) widen(one);
      fit_kappas(channels, tried);
    }
    const double sum = relative_difference(channels);
    if (sum >= least) continue;
    least = sum;
    best = channels;
    kappas = tried;
  }
  std::vector<VmfTerm> terms;
  for (std::size_t i = 0; i < kappas.size(); ++i) {
    const auto weight = [&](std::size_t c) { return best[is_grey ? 0 : c].weights[i]; };
    terms.push_back({{weight(0), weight(1), weight(2)}, kappas[i], vmf_spread(kappas[i])});
  }
  return terms;
}

std::vector<VmfTerm> vmf_terms(const Brdf& brdf) {
  switch (family_of(brdf).fit) {
    case BrdfFit::kNone: return {};
    case BrdfFit::kEqualMean: {
      const double spread = 1.0 / (equivalent_exponent(brdf) + 2.0);  // A = (s + 1) / (s + 2)
      return {{glm::dvec3(1.0), vmf_kappa(spread), spread}};
    }
    case BrdfFit::kOne: {
      const double kappa = equivalent_exponent(brdf);
      return {{glm::dvec3(1.0), kappa, vmf_spread(kappa)}};
    }
    case BrdfFit::kSum: return fit_vmf_terms([&](double e) { return facet_density(brdf, e); }, brdf.term_count);
  }
  return {};
}

}  // namespace multum
