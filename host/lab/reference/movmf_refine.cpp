// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/movmf_refine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "kernels/shared/movmf_refine.h"

namespace multum::reference {
namespace {

constexpr std::array<float, MULTUM_REFINE_BRDFS> kExponents = MULTUM_REFINE_EXPONENTS;
constexpr std::array<float, MULTUM_REFINE_BRDFS> kWeights = MULTUM_REFINE_WEIGHTS;

constexpr float kLooks[MULTUM_REFINE_LOOKS][2] = MULTUM_REFINE_LOOK_XY;

using Matrix = std::vector<std::vector<double>>;
using Vector = std::vector<double>;

struct RefinedLobe {
  double amplitude, spread;  // 1 - |r|
  glm::dvec3 mu, e, f;       // unit vectors; e and f are tangents
  double widening;           // derivative of the spread with respect to the fourth parameter
  double length() const { return 1.0 - spread; }
};

// The samples or lobes that the refined lobes approximate.
struct Shown {
  glm::dvec3 direction;
  double length, weight;
};

// Contains the value of a vMF with mean cosine A, without the factor 1/(2 pi). At the cosine 1 - u, the value is the
// peak times exp(-kappa u). The number u is called the gap.
struct Product {
  double kappa, value;     // kappa, and the value at the gap u
  double by_gap, by_mean;  // derivatives with respect to -u and to A
};

Product product_at(double mean, double gap) {
  Product p;
  p.kappa = std::max(kappa_of_mean_length(mean), static_cast<double>(MULTUM_REFINE_KAPPA_MIN));
  const double sinh = std::sinh(std::min(p.kappa, 300.0)),
               slope_of_mean = 1.0 / (p.kappa * p.kappa) - 1.0 / (sinh * sinh);
  const double below = -std::expm1(-2.0 * p.kappa);
  p.value = p.kappa / below * std::exp(-p.kappa * gap);
  p.by_gap = p.kappa * p.value;
  p.by_mean = p.value * (1.0 / p.kappa - 2.0 * std::exp(-2.0 * p.kappa) / below - gap) / slope_of_mean;
  return p;
}

double mean_cosine(std::size_t brdf) {
  const double s = static_cast<double>(kExponents[brdf]);
  return (s + 1.0) / (s + 2.0);
}
double weight_of(std::size_t brdf) { return static_cast<double>(kWeights[brdf]); }

void set_tangents(RefinedLobe& lobe) {
  const glm::dvec3& m = lobe.mu;
  const double sign = m.z >= 0.0 ? 1.0 : -1.0, p = -1.0 / (sign + m.z), b = m.x * m.y * p;
  lobe.e = {1.0 + sign * m.x * m.x * p, sign * b, -sign * m.x};
  lobe.f = {b, sign + m.y * m.y * p, -m.y};
}

RefinedLobe lobe_of(const MeanLobe& lobe) {
  const double length = glm::length(lobe.r), spread = std::max(1.0 - length, 0.0);
  RefinedLobe refined{std::max(lobe.amplitude, static_cast<double>(MULTUM_REFINE_AMPLITUDE_MIN)),
                      spread,
                      length > 1e-6 ? lobe.r / length : glm::dvec3(0.0, 0.0, 1.0),
                      {},
                      {},
                      spread};
  set_tangents(refined);
  return refined;
}

std::vector<RefinedLobe> start_of(const std::vector<MeanLobe>& lobes) {
  std::vector<RefinedLobe> refined;
  for (const MeanLobe& lobe : lobes) refined.push_back(lobe_of(lobe));
  return refined;
}

std::vector<Shown> shown_by(const std::vector<Sample>& samples) {
  double total = 0.0;
  for (const Sample& sample : samples) total += sample.weight;
  std::vector<Shown> shown;
  for (const Sample& sample : samples) shown.push_back({sample.normal, 1.0, sample.weight / total});
  return shown;
}

void add_shown(const std::vector<RefinedLobe>& lobes, double share, std::vector<Shown>& shown) {
  for (const RefinedLobe& lobe : lobes) shown.push_back({lobe.mu, lobe.length(), share * lobe.amplitude});
}

// Returns the sum of squares, without the squares of the approximated samples, because these squares are constant.
double squares_of(const std::vector<RefinedLobe>& lobes, const std::vector<Shown>& shown) {
  double energy = 0.0;
  for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
    const double c2 = mean_cosine(brdf) * mean_cosine(brdf);
    for (const RefinedLobe& lobe : lobes) {
      const auto product = [&](const glm::dvec3& direction, double length, double weight) {
        return weight_of(brdf) * lobe.amplitude * weight *
               product_at(lobe.length() * length * c2, 1.0 - glm::dot(lobe.mu, direction)).value;
      };
      for (const Shown& other : shown) energy -= 2.0 * product(other.direction, other.length, other.weight);
      for (const RefinedLobe& other : lobes) energy += product(other.mu, other.length(), other.amplitude);
    }
  }
  return energy;
}

// Returns half of the derivative of the sum of squares. This is the products of lobes with lobes, minus the products of
// lobes with samples.
Vector gradient_of(const std::vector<RefinedLobe>& lobes, const std::vector<Shown>& shown) {
  Vector gradient(4 * lobes.size(), 0.0);
  const auto add = [&](std::size_t j, std::size_t brdf, const glm::dvec3& other, double other_length, double factor) {
    const RefinedLobe& lobe = lobes[j];
    const double scale = mean_cosine(brdf) * mean_cosine(brdf) * other_length;
    const Product p = product_at(lobe.length() * scale, 1.0 - glm::dot(lobe.mu, other));
    const double weight = weight_of(brdf) * factor;
    gradient[4 * j] += weight * p.value;
    gradient[4 * j + 1] += weight * lobe.amplitude * p.by_gap * glm::dot(other, lobe.e);
    gradient[4 * j + 2] += weight * lobe.amplitude * p.by_gap * glm::dot(other, lobe.f);
    gradient[4 * j + 3] += weight * lobe.amplitude * p.by_mean * scale * -lobe.widening;
  };
  for (std::size_t j = 0; j < lobes.size(); ++j)
    for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
      for (const Shown& other : shown) add(j, brdf, other.direction, other.length, -other.weight);
      for (const RefinedLobe& other : lobes) add(j, brdf, other.mu, other.length(), other.amplitude);
    }
  return gradient;
}

// Computes the products of the derivatives of lobes j and k. The product of two lobes is V = exp(-u/v)/v, where v is
// the 1/kappa that belongs to the sum of their spreads.
void add_block(const std::vector<RefinedLobe>& lobes, std::size_t j, std::size_t k, Matrix& matrix) {
  const RefinedLobe &one = lobes[j], &other = lobes[k];
  const double gap = j == k ? 0.0 : std::max(1.0 - glm::dot(one.mu, other.mu), 0.0);
  for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
    const double c = mean_cosine(brdf);
    const Product p = product_at(one.length() * other.length() * c * c, gap);
    const double kappa = p.kappa, x = kappa * gap, w = weight_of(brdf) * p.value;
    const double by_t = w * kappa, by_tt = by_t * kappa, by_v = by_t * (x - 1.0);
    const double by_vv = by_tt * (x * x - 4.0 * x + 2.0), by_tv = by_tt * (x - 2.0);
    const double aj = one.amplitude, ak = other.amplitude;
    const glm::dvec3 tangents_j[2] = {one.e, one.f}, tangents_k[2] = {other.e, other.f};
    const auto entry = [&](std::size_t p_row, std::size_t p_column) -> double& {
      return matrix[4 * j + p_row][4 * k + p_column];
    };
    entry(0, 0) += w;
    entry(3, 0) += aj * one.widening * by_v;
    entry(0, 3) += ak * other.widening * by_v;
    entry(3, 3) += aj * ak * one.widening * other.widening * by_vv;
    for (std::size_t a = 0; a < 2; ++a) {
      const double to_other = j == k ? 0.0 : glm::dot(tangents_j[a], other.mu);
      const double to_one = j == k ? 0.0 : glm::dot(tangents_k[a], one.mu);
      entry(1 + a, 0) += aj * by_t * to_other;
      entry(0, 1 + a) += ak * by_t * to_one;
      entry(1 + a, 3) += aj * ak * other.widening * by_tv * to_other;
      entry(3, 1 + a) += aj * ak * one.widening * by_tv * to_one;
      for (std::size_t b = 0; b < 2; ++b)
        entry(1 + a, 1 + b) += aj * ak *
                               (by_tt * to_other * (j == k ? 0.0 : glm::dot(tangents_k[b], one.mu)) +
                                by_t * glm::dot(tangents_j[a], tangents_k[b]));
    }
  }
}

Matrix matrix_of(const std::vector<RefinedLobe>& lobes) {
  Matrix matrix(4 * lobes.size(), Vector(4 * lobes.size(), 0.0));
  for (std::size_t j = 0; j < lobes.size(); ++j)
    for (std::size_t k = 0; k < lobes.size(); ++k) add_block(lobes, j, k, matrix);
  return matrix;
}

// Returns the derivatives of (a r, a) with respect to a lobe's four parameters.
std::array<glm::dvec4, 4> moment_rows(const RefinedLobe& lobe) {
  const double turned = lobe.amplitude * lobe.length();
  return {glm::dvec4(lobe.length() * lobe.mu, 1.0), glm::dvec4(turned * lobe.e, 0.0), glm::dvec4(turned * lobe.f, 0.0),
          glm::dvec4(-lobe.amplitude * lobe.widening * lobe.mu, 0.0)};
}

// Mixes two lobes in equal parts. The fourth parameter of the result is its spread.
RefinedLobe pooled(const RefinedLobe& one, const RefinedLobe& other) {
  const double amplitude = 0.5 * (one.amplitude + other.amplitude);
  const glm::dvec3 sum = 0.5 * (one.amplitude * one.length() * one.mu + other.amplitude * other.length() * other.mu);
  RefinedLobe lobe = lobe_of({sum / amplitude, amplitude});
  lobe.widening = 1.0;
  return lobe;
}

// Returns the derivatives of a mixed lobe's parameters with respect to the parameters of the original lobes. The chain
// rule goes through (a r, a).
Matrix by_lobes(const std::vector<RefinedLobe>& mixed, const std::vector<RefinedLobe>& lobes) {
  Matrix by(4 * lobes.size(), Vector(4 * lobes.size(), 0.0));
  for (std::size_t j = 0; j < lobes.size(); ++j) {
    const RefinedLobe& m = mixed[j];
    const std::array<glm::dvec4, 4> rows = moment_rows(lobes[j]);
    const double long_enough = std::max(m.length(), static_cast<double>(MULTUM_REFINE_LENGTH_MIN));
    for (std::size_t p = 0; p < 4; ++p) {
      const double grown = 0.5 * rows[p].w;
      const glm::dvec3 moved =
          (0.5 * glm::dvec3(rows[p]) - grown * m.length() * m.mu) / m.amplitude;  // derivative of r
      const double values[4] = {grown, glm::dot(m.e, moved) / long_enough, glm::dot(m.f, moved) / long_enough,
                                -glm::dot(m.mu, moved)};
      for (std::size_t q = 0; q < 4; ++q) by[4 * j + q][4 * j + p] = values[q];
    }
  }
  return by;
}

// Contains the value of the minimised function, half of its gradient, and the matrix of a step.
struct System {
  double energy;
  Vector gradient;
  Matrix matrix;
};

void add_midway(const std::vector<RefinedLobe>& lobes, const std::vector<RefinedLobe>& start,
                const std::vector<RefinedLobe>& beside, System& system) {
  const auto weight = static_cast<double>(MULTUM_REFINE_MIDWAY_WEIGHT);
  std::vector<RefinedLobe> mixed;
  for (std::size_t j = 0; j < lobes.size(); ++j) mixed.push_back(pooled(lobes[j], beside[j]));
  std::vector<Shown> shown;
  add_shown(start, 0.5, shown);
  add_shown(beside, 0.5, shown);
  const Vector gradient = gradient_of(mixed, shown);
  const Matrix matrix = matrix_of(mixed), by = by_lobes(mixed, lobes);
  const std::size_t n = gradient.size();
  system.energy += weight * squares_of(mixed, shown);
  for (std::size_t p = 0; p < n; ++p)
    for (std::size_t i = 0; i < n; ++i) {
      system.gradient[p] += weight * by[i][p] * gradient[i];
      for (std::size_t q = 0; q < n; ++q)
        for (std::size_t k = 0; k < n; ++k) system.matrix[p][q] += weight * by[i][p] * matrix[i][k] * by[k][q];
    }
}

// Increases the diagonal. Then adds the constraints that the sum of amplitudes and the mean normal do not change.
void add_moments(const std::vector<RefinedLobe>& lobes, const glm::dvec3& mean, System& system) {
  std::vector<glm::dvec4> rows;
  glm::dvec4 off(-mean, -1.0);
  for (const RefinedLobe& lobe : lobes) {
    for (const glm::dvec4& row : moment_rows(lobe)) rows.push_back(row);
    off += lobe.amplitude * glm::dvec4(lobe.length() * lobe.mu, 1.0);
  }
  const auto weight = static_cast<double>(MULTUM_REFINE_MOMENT_WEIGHT);
  system.energy += weight * glm::dot(off, off);
  for (std::size_t p = 0; p < rows.size(); ++p) {
    system.matrix[p][p] = system.matrix[p][p] * (1.0 + static_cast<double>(MULTUM_REFINE_DAMPING)) +
                          static_cast<double>(MULTUM_REFINE_DIAGONAL_MIN);
    system.gradient[p] += weight * glm::dot(rows[p], off);
    for (std::size_t q = 0; q < rows.size(); ++q) system.matrix[p][q] += weight * glm::dot(rows[p], rows[q]);
  }
}

// Solves matrix * x = right by elimination. The matrix is symmetric and its diagonal was increased, so no pivot is 0.
Vector solve(Matrix matrix, Vector right) {
  const std::size_t n = right.size();
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = matrix[i][k] / matrix[k][k];
      for (std::size_t c = k; c < n; ++c) matrix[i][c] -= factor * matrix[k][c];
      right[i] -= factor * right[k];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t c = i + 1; c < n; ++c) right[i] -= matrix[i][c] * right[c];
    right[i] /= matrix[i][i];
  }
  return right;
}

void take_step(std::vector<RefinedLobe>& lobes, const Vector& step) {
  double total = 0.0;
  for (std::size_t j = 0; j < lobes.size(); ++j) {
    RefinedLobe& lobe = lobes[j];
    lobe.amplitude =
        std::max(lobe.amplitude + step[4 * j], lobe.amplitude * static_cast<double>(MULTUM_REFINE_SHARE_MIN));
    total += lobe.amplitude;
    glm::dvec3 turn = step[4 * j + 1] * lobe.e + step[4 * j + 2] * lobe.f;
    const double most = std::sqrt(lobe.spread + static_cast<double>(MULTUM_REFINE_TURN_MIN));
    if (glm::length(turn) > most) turn *= most / glm::length(turn);
    lobe.mu = glm::normalize(lobe.mu + turn);
    const double spread = lobe.spread * std::exp(std::clamp(step[4 * j + 3], -1.0, 1.0));
    lobe.spread = std::min(spread, std::max(lobe.spread, static_cast<double>(MULTUM_REFINE_SPREAD_MAX)));
    lobe.widening = lobe.spread;
    set_tangents(lobe);
  }
  for (RefinedLobe& lobe : lobes) lobe.amplitude /= total;
}

System system_of(const RefinedTexel& texel, const std::vector<RefinedLobe>& lobes) {
  const std::vector<Shown> shown = shown_by(texel.samples);
  const std::vector<RefinedLobe> start = start_of(texel.lobes);
  System system{squares_of(lobes, shown), gradient_of(lobes, shown), matrix_of(lobes)};
  for (const std::vector<MeanLobe>& beside : texel.beside) add_midway(lobes, start, start_of(beside), system);
  glm::dvec3 mean(0.0);
  for (const Shown& sample : shown) mean += sample.weight * sample.direction;
  add_moments(lobes, mean, system);
  return system;
}

// Returns the sum of the highlights' relative L1 errors over some half vectors.
double seen_error(const std::vector<Sample>& samples, const std::vector<RefinedLobe>& lobes) {
  double total = 0.0, sum = 0.0;
  for (const Sample& sample : samples) total += sample.weight;
  for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
    const double s = static_cast<double>(kExponents[brdf]);
    double whole = 0.0, off = 0.0;
    for (const auto& look : kLooks) {
      const double x = static_cast<double>(look[0]), y = static_cast<double>(look[1]);
      const glm::dvec3 h(x, y, std::sqrt(1.0 - x * x - y * y));
      double seen = 0.0, shown = 0.0;
      for (const Sample& sample : samples)
        seen += sample.weight / total * (s + 1.0) * std::pow(std::max(glm::dot(h, sample.normal), 0.0), s);
      for (const RefinedLobe& lobe : lobes)
        shown += lobe.amplitude *
                 product_at(lobe.length() * mean_cosine(brdf), std::max(1.0 - glm::dot(h, lobe.mu), 0.0)).value;
      whole += seen;
      off += std::abs(shown - seen);
    }
    sum += off / std::max(whole, static_cast<double>(MULTUM_REFINE_SEEN_MIN));
  }
  return sum;
}

}  // namespace

std::vector<MeanLobe> refine(const RefinedTexel& texel, int steps) {
  std::vector<RefinedLobe> lobes = start_of(texel.lobes), best = lobes;
  double least = HUGE_VAL;
  Vector change;
  for (int i = 0;; ++i) {
    System system = system_of(texel, lobes);
    const bool is_better = system.energy < least + static_cast<double>(MULTUM_REFINE_ENERGY_ROUNDING);
    if (is_better) best = lobes;
    least = std::min(least, system.energy);
    if (i == steps) break;
    if (is_better) {
      for (double& value : system.gradient) value = -value;
      change = solve(std::move(system.matrix), std::move(system.gradient));
    } else {
      for (double& value : change) value *= static_cast<double>(MULTUM_REFINE_STEP_CUT);
    }
    lobes = best;
    take_step(lobes, change);
  }
  std::vector<MeanLobe> refined;
  const double slack = texel.beside.empty() ? 1.0 : static_cast<double>(MULTUM_REFINE_LOOK_SLACK);
  if (seen_error(texel.samples, best) >= slack * seen_error(texel.samples, start_of(texel.lobes)))
    best = start_of(texel.lobes);
  for (const RefinedLobe& lobe : best) refined.push_back({lobe.length() * lobe.mu, lobe.amplitude});
  return refined;
}

double seen_error(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes) {
  return seen_error(texel.samples, start_of(lobes));
}

double refined_energy(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes) {
  return system_of(texel, start_of(lobes)).energy;
}

}  // namespace multum::reference
