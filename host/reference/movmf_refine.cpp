// SPDX-License-Identifier: Apache-2.0
#include "host/reference/movmf_refine.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "kernels/shared/movmf_refine.h"

namespace multum::reference {
namespace {

constexpr std::array<float, MULTUM_REFINE_BRDFS> kExponents = MULTUM_REFINE_EXPONENTS;
constexpr std::array<float, MULTUM_REFINE_BRDFS> kWeights = MULTUM_REFINE_WEIGHTS;

using Matrix = std::vector<std::vector<double>>;
using Vector = std::vector<double>;

struct RefinedLobe {
  double amplitude, spread;  // 1 - |r|
  glm::dvec3 mu, e, f;       // unit; e and f tangents
  double length() const { return 1.0 - spread; }
};

// A vMF whose mean cosine is A, up to 1/(2 pi): peak exp(-kappa u).
struct Product {
  double kappa, value;     // at the gap u
  double by_gap, by_mean;  // derivatives in -u and in A
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

std::vector<RefinedLobe> start_of(const std::vector<MeanLobe>& lobes) {
  std::vector<RefinedLobe> refined;
  for (const MeanLobe& lobe : lobes) {
    const double length = glm::length(lobe.r);
    refined.push_back({std::max(lobe.amplitude, static_cast<double>(MULTUM_REFINE_AMPLITUDE_MIN)),
                       std::max(1.0 - length, 0.0),
                       length > 1e-6 ? lobe.r / length : glm::dvec3(0.0, 0.0, 1.0),
                       {},
                       {}});
  }
  return refined;
}

// Half of the derivative of the squares: lobes times lobes less lobes times samples.
Vector gradient_of(const std::vector<RefinedLobe>& lobes, const std::vector<Sample>& samples, double total) {
  Vector gradient(4 * lobes.size(), 0.0);
  const auto add = [&](std::size_t j, std::size_t brdf, const glm::dvec3& other, double other_length, double factor) {
    const RefinedLobe& lobe = lobes[j];
    const double scale = mean_cosine(brdf) * mean_cosine(brdf) * other_length;
    const Product p = product_at(lobe.length() * scale, 1.0 - glm::dot(lobe.mu, other));
    const double weight = weight_of(brdf) * factor;
    gradient[4 * j] += weight * p.value;
    gradient[4 * j + 1] += weight * lobe.amplitude * p.by_gap * glm::dot(other, lobe.e);
    gradient[4 * j + 2] += weight * lobe.amplitude * p.by_gap * glm::dot(other, lobe.f);
    gradient[4 * j + 3] += weight * lobe.amplitude * p.by_mean * scale * -lobe.spread;
  };
  for (std::size_t j = 0; j < lobes.size(); ++j)
    for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
      for (const Sample& sample : samples) add(j, brdf, sample.normal, 1.0, -sample.weight / total);
      for (const RefinedLobe& other : lobes) add(j, brdf, other.mu, other.length(), other.amplitude);
    }
  return gradient;
}

// Products of the derivatives of lobes j and k, with v = 1/kappa for the sum of the spreads: V = exp(-u/v)/v.
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
    entry(3, 0) += aj * one.spread * by_v;
    entry(0, 3) += ak * other.spread * by_v;
    entry(3, 3) += aj * ak * one.spread * other.spread * by_vv;
    for (std::size_t a = 0; a < 2; ++a) {
      const double to_other = j == k ? 0.0 : glm::dot(tangents_j[a], other.mu);
      const double to_one = j == k ? 0.0 : glm::dot(tangents_k[a], one.mu);
      entry(1 + a, 0) += aj * by_t * to_other;
      entry(0, 1 + a) += ak * by_t * to_one;
      entry(1 + a, 3) += aj * ak * other.spread * by_tv * to_other;
      entry(3, 1 + a) += aj * ak * one.spread * by_tv * to_one;
      for (std::size_t b = 0; b < 2; ++b)
        entry(1 + a, 1 + b) += aj * ak *
                               (by_tt * to_other * (j == k ? 0.0 : glm::dot(tangents_k[b], one.mu)) +
                                by_t * glm::dot(tangents_j[a], tangents_k[b]));
    }
  }
}

// Holds the sum of amplitudes and the mean normal, and raises the diagonal.
void add_moments(const std::vector<RefinedLobe>& lobes, const glm::dvec3& mean, Matrix& matrix, Vector& gradient) {
  std::vector<std::array<double, 4>> rows;
  std::array<double, 4> off = {-mean.x, -mean.y, -mean.z, -1.0};
  for (const RefinedLobe& lobe : lobes) {
    const glm::dvec3 r = lobe.length() * lobe.mu, e = lobe.amplitude * lobe.length() * lobe.e;
    const glm::dvec3 f = lobe.amplitude * lobe.length() * lobe.f, wider = -lobe.amplitude * lobe.spread * lobe.mu;
    rows.push_back({r.x, r.y, r.z, 1.0});
    for (const glm::dvec3& row : {e, f, wider}) rows.push_back({row.x, row.y, row.z, 0.0});
    for (int i = 0; i < 3; ++i) off[static_cast<std::size_t>(i)] += lobe.amplitude * r[i];
    off[3] += lobe.amplitude;
  }
  const auto dot = [](const std::array<double, 4>& a, const std::array<double, 4>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  };
  const auto weight = static_cast<double>(MULTUM_REFINE_MOMENT_WEIGHT);
  for (std::size_t p = 0; p < rows.size(); ++p) {
    gradient[p] += weight * dot(rows[p], off);
    for (std::size_t q = 0; q < rows.size(); ++q) matrix[p][q] += weight * dot(rows[p], rows[q]);
  }
  for (std::size_t p = 0; p < rows.size(); ++p)
    matrix[p][p] = matrix[p][p] * (1.0 + static_cast<double>(MULTUM_REFINE_DAMPING)) +
                   static_cast<double>(MULTUM_REFINE_DIAGONAL_MIN);
}

// matrix * x = right, by elimination; the matrix is symmetric with a raised diagonal, so that pivots are there.
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
  }
  for (RefinedLobe& lobe : lobes) lobe.amplitude /= total;
}

double total_weight(const std::vector<Sample>& samples) {
  double total = 0.0;
  for (const Sample& sample : samples) total += sample.weight;
  return total;
}

}  // namespace

std::vector<MeanLobe> refine(const std::vector<Sample>& samples, const std::vector<MeanLobe>& given, int steps) {
  const double total = total_weight(samples);
  glm::dvec3 mean(0.0);
  for (const Sample& sample : samples) mean += sample.weight / total * sample.normal;
  std::vector<RefinedLobe> lobes = start_of(given);
  for (int i = 0; i < steps; ++i) {
    for (RefinedLobe& lobe : lobes) set_tangents(lobe);
    Matrix matrix(4 * lobes.size(), Vector(4 * lobes.size(), 0.0));
    for (std::size_t j = 0; j < lobes.size(); ++j)
      for (std::size_t k = 0; k < lobes.size(); ++k) add_block(lobes, j, k, matrix);
    Vector gradient = gradient_of(lobes, samples, total);
    add_moments(lobes, mean, matrix, gradient);
    for (double& value : gradient) value = -value;
    take_step(lobes, solve(std::move(matrix), std::move(gradient)));
  }
  // Every lobe takes what the mean normal is off by.
  glm::dvec3 off = mean;
  for (const RefinedLobe& lobe : lobes) off -= lobe.amplitude * lobe.length() * lobe.mu;
  std::vector<MeanLobe> refined;
  for (const RefinedLobe& lobe : lobes) {
    const glm::dvec3 r = lobe.length() * lobe.mu + off;
    refined.push_back({r / std::max(glm::length(r), 1.0), lobe.amplitude});
  }
  return refined;
}

double refined_energy(const std::vector<Sample>& samples, const std::vector<MeanLobe>& given) {
  const double total = total_weight(samples);
  const std::vector<RefinedLobe> lobes = start_of(given);
  double energy = 0.0;
  for (std::size_t brdf = 0; brdf < MULTUM_REFINE_BRDFS; ++brdf) {
    const double c2 = mean_cosine(brdf) * mean_cosine(brdf);
    for (const RefinedLobe& lobe : lobes) {
      for (const Sample& sample : samples)
        energy -= 2.0 * weight_of(brdf) * lobe.amplitude * sample.weight / total *
                  product_at(lobe.length() * c2, 1.0 - glm::dot(lobe.mu, sample.normal)).value;
      for (const RefinedLobe& other : lobes)
        energy += weight_of(brdf) * lobe.amplitude * other.amplitude *
                  product_at(lobe.length() * other.length() * c2, 1.0 - glm::dot(lobe.mu, other.mu)).value;
    }
  }
  return energy;
}

}  // namespace multum::reference
