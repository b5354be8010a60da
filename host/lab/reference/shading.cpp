// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace multum::reference {
namespace {

constexpr double kPi = std::numbers::pi;

/// Computes the integral of f(angle of n and w) vMF(n) dn over all n whose angle to w is between f_low and f_reach. The
/// polar coordinates around w are the angle a and the azimuth phi. Beyond ten standard deviations, each factor is below
/// e^-50, so `a` covers only angles within ten standard deviations. The azimuth is periodic, so the trapezoid rule
/// converges exponentially if the step is smaller than the width of the vMF.
double convolve(const std::function<double(double)>& f, double f_low, double f_reach, double kappa, double theta,
                int rings) {
  const double reach = 10.0 / std::sqrt(kappa);
  const double low = std::max(f_low, theta - reach);
  const double high = std::min({kPi, theta + reach, f_reach});
  if (high <= low) return 0.0;
  const int spokes = 64 + static_cast<int>(12.0 * std::sqrt(kappa));
  double sum = 0.0;
  for (int i = 0; i < rings; ++i) {  // this is the midpoint rule
    const double a = low + (high - low) * (i + 0.5) / rings;
    double ring = 0.0;
    for (int k = 0; k < spokes; ++k) {
      const double phi = 2.0 * kPi * (k + 0.5) / spokes;
      const double cosine = std::cos(a) * std::cos(theta) + std::sin(a) * std::sin(theta) * std::cos(phi);
      ring += std::exp(kappa * (cosine - 1.0));
    }
    sum += f(a) * std::sin(a) * ring;
  }
  const double density = kappa / (2.0 * kPi * -std::expm1(-2.0 * kappa));
  return sum * density * (high - low) / rings * 2.0 * kPi / spokes;
}

constexpr int kRings = 400;

}  // namespace

double vmf_spread(double kappa) {
  if (kappa < 1e-2) return 1.0 - kappa / 3.0 + kappa * kappa * kappa / 45.0;
  return 1.0 / kappa - (kappa < 300.0 ? 2.0 / std::expm1(2.0 * kappa) : 0.0);
}

double vmf_kappa(double spread) {
  double low = 1e-9;
  double high = 1e12;
  for (int i = 0; i < 200; ++i) {
    const double middle = std::sqrt(low * high);
    (vmf_spread(middle) > spread ? low : high) = middle;
  }
  return low;
}

double zonal_of_vmf(double kappa, int l) {
  const double middle = l + 60.5;
  double quotient = kappa / (middle + std::sqrt(middle * middle + kappa * kappa)), value = 1.0;
  for (int k = l + 59; k >= 1; --k) {
    quotient = kappa / (2.0 * k + 1.0 + kappa * quotient);
    if (k <= l) value *= quotient;
  }
  return value;
}

double vmf_density(double kappa, double theta) {
  const double half = std::sin(0.5 * theta);
  if (kappa < 1e-8) return 1.0 / (4.0 * kPi);
  return kappa / (2.0 * kPi * -std::expm1(-2.0 * kappa)) * std::exp(-2.0 * kappa * half * half);
}

double blinn_phong(double s, double theta) {
  return theta < 0.5 * kPi ? (s + 1.0) / (2.0 * kPi) * std::pow(std::cos(theta), s) : 0.0;
}

double convolved_blinn_phong(double s, double kappa, double theta) {
  const double reach = std::min(0.5 * kPi, 10.0 / std::sqrt(s));
  return convolve([s](double a) { return blinn_phong(s, a); }, 0.0, reach, kappa, theta, kRings);
}

double convolved_lambert(double kappa, double theta) {
  return convolve([](double a) { return std::cos(a); }, 0.0, 0.5 * kPi, kappa, theta, kRings);
}

double mean_cosine(double kappa, double theta) {
  if (kappa < 1e4) return kappa > 0.0 ? convolved_lambert(kappa, theta) : 0.25;
  const double sigma = 1.0 / std::sqrt(kappa), x = std::cos(theta) / sigma;
  return sigma * (std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi) + x * 0.5 * std::erfc(-x / std::sqrt(2.0)));
}

double convolved_vmf(double kappa_f, double kappa, double theta) {
  const double reach = std::min(kPi, 10.0 / std::sqrt(kappa_f));
  return convolve([kappa_f](double a) { return vmf_density(kappa_f, a); }, 0.0, reach, kappa, theta, kRings);
}

double convolved(const std::function<double(double)>& f, double narrow, double kappa, double theta) {
  // Splits the integral into the peak and the tail up to the horizon.
  const double middle = std::min(narrow, 0.25 * kPi);
  return convolve(f, 0.0, middle, kappa, theta, 150) + convolve(f, middle, 0.5 * kPi, kappa, theta, 150);
}

// Integrates in polar coordinates around the mean of the product of both vMFs, within ten standard deviations.
Highlight highlight(const std::function<double(double)>& f, double facet_kappa, double kappa, const glm::dvec3& mu,
                    const glm::dvec3& h, const glm::dvec3& l) {
  constexpr int kCircles = 96, kSpokes = 96;
  const glm::dvec3 sum = facet_kappa * h + kappa * mu;
  const double size = glm::length(sum), reach = std::min(kPi, 10.0 / std::sqrt(std::max(size, 1e-3)));
  const glm::dvec3 middle = size > 1e-9 ? sum / size : mu;
  const glm::dvec3 side =
      glm::normalize(glm::cross(middle, std::abs(middle.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 across = glm::cross(middle, side);
  Highlight result = {0.0, 0.0};
  for (int i = 0; i < kCircles; ++i) {  // this is the midpoint rule
    const double a = reach * (i + 0.5) / kCircles;
    for (int k = 0; k < kSpokes; ++k) {
      const double phi = 2.0 * kPi * (k + 0.5) / kSpokes;
      const glm::dvec3 n = std::cos(a) * middle + std::sin(a) * (std::cos(phi) * side + std::sin(phi) * across);
      const double density = vmf_density(kappa, 2.0 * std::asin(std::min(1.0, 0.5 * glm::length(n - mu))));
      const double value = f(2.0 * std::asin(std::min(1.0, 0.5 * glm::length(n - h)))) * density * std::sin(a);
      result.with_cosine += value * std::max(glm::dot(n, l), 0.0);
      result.without_cosine += value;
    }
  }
  const double cell = reach / kCircles * 2.0 * kPi / kSpokes;
  return {result.with_cosine * cell, result.without_cosine * cell};
}

double ggx(double alpha, double theta) {
  if (theta >= 0.5 * kPi) return 0.0;
  const double c = std::cos(theta), s = std::sin(theta);
  const double y = alpha * alpha * c * c + s * s;
  return alpha * alpha / (kPi * y * y);
}

double convolved_ggx(double alpha, double kappa, double theta) {
  return convolved([alpha](double a) { return ggx(alpha, a); }, 6.0 * alpha, kappa, theta);
}

double smith_visibility(double alpha, double n_l, double n_v) {
  // For each direction, G1 is 2 c / (c + sqrt(alpha^2 + (1 - alpha^2) c^2)), and Lambda is 1 / G1 - 1.
  const auto lambda = [alpha](double c) {
    return 0.5 * (std::sqrt(alpha * alpha + (1.0 - alpha * alpha) * c * c) / c - 1.0);
  };
  return 1.0 / (1.0 + lambda(n_l) + lambda(n_v)) / (4.0 * n_l * n_v);
}

double groove_visibility(double n_l, double n_v, double n_h, double v_h) {
  return std::min({1.0, 2.0 * n_h * n_v / v_h, 2.0 * n_h * n_l / v_h}) / (4.0 * n_l * n_v);
}

double schlick(double f0, double v_h) { return f0 + (1.0 - f0) * std::pow(1.0 - v_h, 5.0); }

double product_blinn_phong(double s, double spread, double theta) {
  const double r = 1.0 - spread;
  const double q = spread + r / (s + 2.0);
  const double power = std::max((1.0 - 2.0 * q) / q, 0.0);
  const double weight = r * r / (r * r + 1.4 * spread * (s + 2.0));
  return weight * blinn_phong(power, theta) + (1.0 - weight) * vmf_density(vmf_kappa(q), theta);
}

}  // namespace multum::reference
