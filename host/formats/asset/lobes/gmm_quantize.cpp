// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/gmm_quantize.h"

#include <half.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "host/formats/asset/lobes/lobe_rounding.h"

namespace multum {
namespace {

// If 2 sigma^2 of a lobe is below this value (8 roundings of 2^-24), the lobe cannot be distinguished from a single
// direction, because 32-bit floats have rounding errors of this size.
constexpr double kSpreadZero = 5e-7;

float clamped_step_value(double steps) { return static_cast<float>(std::clamp(steps, -32767.0, 32767.0) * kSnormStep); }

float grid_nearest(double value, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kHalf) return static_cast<float>(half(static_cast<float>(value)));
  return clamped_step_value(std::round(value * kSnormSteps));
}

// Returns 2 sigma^2 of the lobe (a mu, a (2 sigma^2 + |mu|^2), a).
double planar_spread(const glm::vec4& lobe) {
  const double a = static_cast<double>(lobe.w), x = static_cast<double>(lobe.x) / a,
               y = static_cast<double>(lobe.y) / a;
  return static_cast<double>(lobe.z) / a - x * x - y * y;
}

float grid_inwards(double value, StorageEncoding encoding) {
  const float below = grid_below(std::abs(value), encoding);
  return value < 0.0 ? -below : below;
}

// Rounds the mean to nearest, then the third value about the rounded mean. If the third value would exceed a, rounds
// the mean inwards instead, because E|p|^2 never exceeds a, and snorm16 cannot store more. For a single direction, the
// third value is rounded down, so that readers clamp its variance to 0. NaN and infinity remain unchanged, so that
// verify_movmf() reports them.
glm::vec4 round_gaussian(const glm::vec4& lobe, double a, StorageEncoding encoding) {
  if (a <= 0.0) return glm::vec4(0.0f);
  const double spread = planar_spread(lobe), scale = a / static_cast<double>(lobe.w);
  if (!std::isfinite(spread)) return lobe;
  const double exact_x = static_cast<double>(lobe.x) * scale, exact_y = static_cast<double>(lobe.y) * scale;
  glm::vec4 rounded(grid_nearest(exact_x, encoding), grid_nearest(exact_y, encoding), 0.0f, static_cast<float>(a));
  const auto square = [&] {
    const double x = static_cast<double>(rounded.x), y = static_cast<double>(rounded.y);
    return (x * x + y * y) / a;
  };
  if (a * spread + square() > a) {
    rounded.x = grid_inwards(exact_x, encoding);
    rounded.y = grid_inwards(exact_y, encoding);
  }
  rounded.z = spread > kSpreadZero ? grid_nearest(a * spread + square(), encoding) : grid_below(square(), encoding);
  return rounded;
}

void round_gaussians(glm::vec4* lobes, const double* amplitudes, std::size_t count, StorageEncoding encoding) {
  for (std::size_t i = 0; i < count; ++i) lobes[i] = round_gaussian(lobes[i], amplitudes[i], encoding);
}

bool is_sharp(const glm::vec4& lobe, double variance_min) {
  const double spread = planar_spread(lobe);
  return spread > kSpreadZero && 0.5 * spread < variance_min;
}

}  // namespace

float gmm_variance(const glm::vec4& lobe) {
  return lobe.w > 0.0f ? static_cast<float>(std::max(0.5 * planar_spread(lobe), 0.0)) : 0.0f;
}

glm::vec3 rough_point(const glm::vec3& shortened) {
  const glm::dvec3 n(shortened);
  const double length = glm::length(n), spread = std::max(1.0 - length, 0.0);
  const glm::dvec2 p = glm::dvec2(n) / length;
  const double square = std::min(glm::dot(p, p), 1.0);
  return {p, std::min(square + 2.0 * spread / (1.0 + spread) * (1.0 - 0.5 * square), 1.0)};
}

// Inverts v = spread / (1 + spread) (1 - |p|^2 / 2). If v was limited at the rim, returns the smallest possible spread.
glm::vec3 shortened_normal(const glm::vec3& rough_point) {
  const glm::dvec2 p(rough_point);
  const double square = std::min(glm::dot(p, p), 1.0);
  const double variance = std::max(static_cast<double>(rough_point.z) - square, 0.0) / (2.0 - square);
  const double length = 1.0 - std::min(variance / (1.0 - variance), 0.5);
  return length * glm::dvec3(p, std::sqrt(1.0 - square));
}

glm::vec3 point_of_normal(const glm::vec3& n, bool is_shortened) {
  return is_shortened ? rough_point(n) : glm::vec3(n.x, n.y, n.x * n.x + n.y * n.y);
}

glm::vec3 normal_of_point(const glm::vec3& point, bool is_shortened) {
  if (is_shortened) return shortened_normal(point);
  return {point.x, point.y, std::sqrt(std::max(0.0f, 1.0f - (point.x * point.x + point.y * point.y)))};
}

float gmm_kappa_max(StorageEncoding encoding) {
  // At these kappas, half a step of the third value changes 2 sigma^2 by a quarter. A step of snorm16 is 1/32767. A
  // step of 16-bit floats is 1/2048 near the rim, where the third value is near 1, and smaller elsewhere.
  // GmmQuantizeTest.KeepsVariance measures this.
  switch (encoding) {
    case StorageEncoding::kSnorm16: return 30000.0f;
    case StorageEncoding::kHalf: return 2000.0f;
    case StorageEncoding::kFloat: return 1.0e6f;
  }
  return 0.0f;
}

SharpLobes count_sharp_gaussians(const MovmfLevel& level, StorageEncoding encoding, int threads) {
  if (encoding == StorageEncoding::kFloat) return {};
  return count_lobes(level, threads, is_sharp, 1.0 / static_cast<double>(gmm_kappa_max(encoding)));
}

void quantize_gmm(MovmfLevel& rows, StorageEncoding encoding, int threads) {
  round_rows(rows, encoding, threads, round_gaussians);
}

float grid_below(double value, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) return clamped_step_value(std::floor(value * kSnormSteps));
  const auto nearest = static_cast<float>(value);
  if (encoding == StorageEncoding::kFloat)
    return static_cast<double>(nearest) > value ? std::nextafter(nearest, -1.0f) : nearest;
  half h(nearest);
  if (static_cast<double>(static_cast<float>(h)) > value && h.bits() != 0)
    h.setBits(static_cast<unsigned short>(h.bits() - 1));
  return static_cast<float>(h);
}

}  // namespace multum
