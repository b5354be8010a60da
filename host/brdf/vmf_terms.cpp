// SPDX-License-Identifier: Apache-2.0
// Levenberg and Marquardt on the logarithms of weights and kappas. Minimised is the sum over e of (sum_i w_i vMF_i -
// f)^2 / f, weight = solid angle: a relative error that neither the peak nor the tail of GGX escapes. It is near what
// relative L1 punishes, and it bends no sign. Below the horizon of h, where f is 0 and every vMF is not, the same
// square is divided by kHorizonWeight^-1 f(horizon): without it, broad terms fill the hemisphere's rim well and leak
// under it, which a lobe of kappa 3 then brings back (5.5 % at alpha 0.4); with more of it the rim suffers. Measured
// over alpha 0.05 to 0.4 and kappa 3 to 2000, four terms, relative L1 at most: weight 0: 5.5 %, 0.03: 3.6, 0.1: 2.7,
// 0.3: 4.9.
#include "host/brdf/vmf_terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/base/error.h"
#include "host/brdf/facet_distribution.h"

namespace multum {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kHorizonWeight = 0.1;
constexpr double kKappaMin = 0.05;  // nearly the same in all directions
constexpr double kKappaMax = 1e7;
constexpr int kRoundCountMax = 80;

// Where f is compared: e evenly in its logarithm, then evenly under the horizon. f of it, and 1 / tolerance.
struct Sample {
  double e, value, scale;
};

constexpr int kUpperCount = 240, kLowerCount = 24, kCountMax = kBrdfTermCountMax;
constexpr double kLeast = 1e-8;

// Up to just above the horizon, where densities of a hemisphere end.
double node(int i) {
  return (1.0 - 1e-9) * std::exp(std::log(kLeast) * (1.0 - static_cast<double>(i) / (kUpperCount - 1)));
}

// `value(i)` of the upper nodes.
template <typename Value>
std::vector<Sample> make_samples(const Value& value) {
  std::vector<Sample> samples;
  const double step = -std::log(kLeast) / (kUpperCount - 1);
  double largest = 0.0;
  for (int i = 0; i < kUpperCount; ++i) largest = std::max(largest, value(i));
  for (int i = 0; i < kUpperCount; ++i) {
    const double e = node(i), f = value(i);
    samples.push_back({e, f, std::sqrt(2.0 * kPi * e * step / std::max(f, 1e-6 * largest))});
  }
  const double horizon = std::max(samples.back().value, 1e-6 * largest);
  for (int i = 0; i < kLowerCount; ++i)
    samples.push_back(
        {1.0 + (i + 0.5) / kLowerCount, 0.0, std::sqrt(kHorizonWeight * 2.0 * kPi / kLowerCount / horizon)});
  return samples;
}

double unit_vmf(double kappa, double e) {
  return kappa / (2.0 * kPi * -std::expm1(-2.0 * kappa)) * std::exp(-kappa * e);
}

using Parameters = std::array<double, 2 * kCountMax>;  // log w_i, then log kappa_i

double cost(const std::vector<Sample>& samples, const Parameters& x, int count) {
  double sum = 0.0;
  for (const Sample& s : samples) {
    double model = 0.0;
    for (int i = 0; i < count; ++i)
      model +=
          std::exp(x[static_cast<std::size_t>(i)]) * unit_vmf(std::exp(x[static_cast<std::size_t>(count + i)]), s.e);
    const double residual = (model - s.value) * s.scale;
    sum += residual * residual;
  }
  return sum;
}

using Matrix = std::array<std::array<double, 2 * kCountMax>, 2 * kCountMax>;

// Gaussian elimination of a symmetric positive matrix; `n` unknowns.
Parameters solve(Matrix a, Parameters b, std::size_t n) {
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  Parameters x{};
  for (std::size_t k = n; k-- > 0;) {
    double sum = b[k];
    for (std::size_t j = k + 1; j < n; ++j) sum -= a[k][j] * x[j];
    x[k] = sum / a[k][k];
  }
  return x;
}

// J^T J and -J^T r of the residuals.
void normal_equations(const std::vector<Sample>& samples, const Parameters& x, int count, Matrix& matrix,
                      Parameters& right) {
  matrix = {};
  right = {};
  const auto n = static_cast<std::size_t>(count);
  for (const Sample& s : samples) {
    Parameters row{};
    double model = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double kappa = std::exp(x[n + i]), decay = std::exp(-2.0 * kappa);
      const double term = std::exp(x[i]) * unit_vmf(kappa, s.e);
      model += term;
      row[i] = term * s.scale;
      // d log vMF / d log kappa
      row[n + i] = row[i] * (1.0 - kappa * (2.0 * decay / -std::expm1(-2.0 * kappa) + s.e));
    }
    const double residual = (model - s.value) * s.scale;
    for (std::size_t i = 0; i < 2 * n; ++i) {
      right[i] -= row[i] * residual;
      for (std::size_t j = 0; j < 2 * n; ++j) matrix[i][j] += row[i] * row[j];
    }
  }
}

// A ladder of kappas below that of the peak.
Parameters start(const std::vector<Sample>& samples, int count) {
  double total = 0.0;
  for (const Sample& s : samples) total += s.value * s.value * s.scale * s.scale;  // the integral of f
  const double peak = 2.0 * kPi * samples[0].value / total;
  Parameters x{};
  const auto n = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = std::log(total * std::pow(0.5, static_cast<double>(i) + (i + 1 < n || n == 1 ? 1.0 : 0.0)));
    x[n + i] =
        std::log(std::clamp((count == 1 ? 0.7 : 1.7) * peak * std::pow(0.2, static_cast<double>(i)), 0.1, kKappaMax));
  }
  return x;
}

Parameters fit(const std::vector<Sample>& samples, int count) {
  const auto n = static_cast<std::size_t>(count);
  Parameters x = start(samples, count);
  double best = cost(samples, x, count), damping = 1e-2;
  for (int round = 0; round < kRoundCountMax; ++round) {
    Matrix matrix;
    Parameters right;
    normal_equations(samples, x, count, matrix, right);
    double trace = 0.0;
    for (std::size_t i = 0; i < 2 * n; ++i) trace += matrix[i][i];
    bool improved = false, finished = true;
    for (int attempt = 0; attempt < 12 && !improved; ++attempt) {
      Matrix damped = matrix;
      for (std::size_t i = 0; i < 2 * n; ++i) damped[i][i] += damping * (matrix[i][i] + 1e-9 * trace) + 1e-300;
      const Parameters step = solve(damped, right, 2 * n);
      Parameters next = x;
      for (std::size_t i = 0; i < n; ++i) {
        next[i] = std::max(x[i] + std::clamp(step[i], -1.0, 1.0), -30.0);
        next[n + i] =
            std::clamp(x[n + i] + std::clamp(step[n + i], -1.0, 1.0), std::log(kKappaMin), std::log(kKappaMax));
      }
      const double tried = cost(samples, next, count);
      improved = tried < best;
      damping *= improved ? 0.3 : 4.0;
      if (!improved) continue;
      finished = best - tried < 1e-7 * best;
      best = tried;
      x = next;
    }
    if (finished) break;
  }
  return x;
}

// The weights >= 0 of one channel, for kappas that stand: coordinate descent on the same squares.
std::vector<double> fit_weights(const std::vector<Sample>& samples, const std::vector<double>& kappas) {
  const std::size_t n = kappas.size();
  std::vector<std::vector<double>> gram(n, std::vector<double>(n, 0.0));
  std::vector<double> right(n, 0.0), weights(n, 0.0);
  for (const Sample& s : samples)
    for (std::size_t i = 0; i < n; ++i) {
      const double row = unit_vmf(kappas[i], s.e) * s.scale;
      right[i] += row * s.value * s.scale;
      for (std::size_t j = 0; j < n; ++j) gram[i][j] += row * unit_vmf(kappas[j], s.e) * s.scale;
    }
  for (int round = 0; round < 4000; ++round)
    for (std::size_t i = 0; i < n; ++i) {
      double rest = right[i];
      for (std::size_t j = 0; j < n; ++j) rest -= j == i ? 0.0 : gram[i][j] * weights[j];
      weights[i] = std::max(rest / gram[i][i], 0.0);
    }
  return weights;
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
  const auto value = [&](int i) { return values[static_cast<std::size_t>(i)]; };
  const Parameters x = fit(make_samples([&](int i) { return (value(i).x + value(i).y + value(i).z) / 3.0; }), count);
  std::vector<VmfTerm> terms;
  std::vector<double> kappas;
  for (int i = 0; i < count; ++i) {
    kappas.push_back(std::exp(x[static_cast<std::size_t>(count + i)]));
    terms.push_back({glm::dvec3(std::exp(x[static_cast<std::size_t>(i)])), kappas.back(), vmf_spread(kappas.back())});
  }
  const bool is_grey =
      std::all_of(values.begin(), values.end(), [](const glm::dvec3& v) { return v.x == v.y && v.y == v.z; });
  for (int channel = 0; channel < 3 && !is_grey; ++channel) {
    const std::vector<double> weights = fit_weights(make_samples([&](int i) { return value(i)[channel]; }), kappas);
    for (std::size_t i = 0; i < terms.size(); ++i) terms[i].weight[channel] = weights[i];
  }
  return terms;
}

std::vector<VmfTerm> vmf_terms(const Brdf& brdf) {
  switch (brdf.kind) {
    case BrdfKind::kLambert: return {};
    case BrdfKind::kBlinnPhong: {
      const double spread = 1.0 / (static_cast<double>(brdf.exponent) + 2.0);  // A = (s + 1) / (s + 2)
      return {{glm::dvec3(1.0), vmf_kappa(spread), spread}};
    }
    case BrdfKind::kTorranceSparrow:
    case BrdfKind::kCookTorrance: {
      const double kappa = equivalent_exponent(brdf);
      return {{glm::dvec3(1.0), kappa, vmf_spread(kappa)}};
    }
    case BrdfKind::kGgx:
    case BrdfKind::kMeasured: return fit_vmf_terms([&](double e) { return facet_density(brdf, e); }, brdf.term_count);
  }
  return {};
}

}  // namespace multum
