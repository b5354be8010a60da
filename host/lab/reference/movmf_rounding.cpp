// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/movmf_rounding.h"

#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum::reference {
namespace {

constexpr float kSnormSteps = 32767.0f;
constexpr double kSpreadZero = 5e-7;

// Returns the two neighbours of a value on the grid. The magnitude of one neighbour is at most the magnitude of the
// value, and the magnitude of the other neighbour is at least the magnitude of the value.
struct Bracket {
  float inner;
  float outer;
};

Bracket bracket_snorm(double value) {
  const double steps = value * static_cast<double>(kSnormSteps);
  const double inner = std::trunc(steps);
  const double outer = steps == inner ? inner : inner + (steps > 0 ? 1.0 : -1.0);
  return {static_cast<float>(inner / static_cast<double>(kSnormSteps)),
          static_cast<float>(outer / static_cast<double>(kSnormSteps))};
}

Bracket bracket_half(double value) {
  const half nearest(static_cast<float>(value));
  const auto rounded = static_cast<double>(static_cast<float>(nearest));
  if (rounded == value) return {static_cast<float>(nearest), static_cast<float>(nearest)};
  half other = nearest;
  // 16-bit floats with the same sign have the same order as their bit patterns.
  const bool nearest_is_inner = std::abs(rounded) < std::abs(value);
  const auto bits = nearest.bits();
  other.setBits(static_cast<unsigned short>(nearest_is_inner ? bits + 1 : bits - 1));
  if (nearest_is_inner) return {static_cast<float>(nearest), static_cast<float>(other)};
  return {static_cast<float>(other), static_cast<float>(nearest)};
}

// Performs steps 2 and 3 for one lobe, whose amplitude has been rounded to `a`.
template <typename BracketOf>
glm::vec4 round_lobe(const glm::dvec3& r, float a, const BracketOf& bracket_of) {
  if (a <= 0.0f) return glm::vec4(0.0f);
  const double length = glm::length(r);
  const bool single_direction = length >= 1.0 - kSpreadZero;
  const auto amplitude = static_cast<double>(a);
  const glm::dvec3 target = r * (amplitude / (single_direction ? length : 1.0));
  const Bracket x = bracket_of(target.x), y = bracket_of(target.y), z = bracket_of(target.z);
  const double wanted = single_direction ? amplitude : amplitude * length;
  const glm::dvec3 direction = length > 0.0 ? r / length : glm::dvec3(0.0);
  glm::vec3 best(x.outer, y.outer, z.outer);  // this vector is never shorter than the target
  double best_cost = HUGE_VAL;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const glm::vec3 candidate((corner & 1u) != 0 ? x.outer : x.inner, (corner & 2u) != 0 ? y.outer : y.inner,
                              (corner & 4u) != 0 ? z.outer : z.inner);
    const double projection = glm::dot(glm::dvec3(candidate), direction);
    if (single_direction && projection < wanted) continue;
    // For single directions, minimises the rotation. For other lobes, minimises the error of the projection. In both
    // cases, the lobe is rotated by at most one step.
    const double cost = single_direction ? glm::length(glm::dvec3(candidate) - target) : std::abs(projection - wanted);
    if (cost < best_cost) {
      best_cost = cost;
      best = candidate;
    }
  }
  return glm::vec4(best, a);
}

// Performs step 1 for snorm16: rounds the amplitudes to integers whose sum is 32767. The amplitudes with the largest
// remainders are rounded up. If two remainders are equal, the lobe with the lower index comes first.
void round_amplitudes_snorm(std::array<float, kLobeCountMax>& a, int count) {
  double total = 0.0;
  for (int j = 0; j < count; ++j) total += static_cast<double>(a[static_cast<std::size_t>(j)]);
  if (!(total > 0.0)) return;
  std::array<double, kLobeCountMax> remainder{};
  std::array<int, kLobeCountMax> steps{};
  int missing = static_cast<int>(kSnormSteps);
  for (std::size_t j = 0; j < static_cast<std::size_t>(count); ++j) {
    const double exact = static_cast<double>(a[j]) / total * static_cast<double>(kSnormSteps);
    steps[j] = static_cast<int>(std::floor(exact));
    remainder[j] = exact - steps[j];
    missing -= steps[j];
  }
  for (; missing > 0; --missing) {
    const auto largest = std::max_element(remainder.begin(), remainder.begin() + count);
    ++steps[static_cast<std::size_t>(largest - remainder.begin())];
    *largest = -1.0;
  }
  for (std::size_t j = 0; j < static_cast<std::size_t>(count); ++j) a[j] = static_cast<float>(steps[j]) / kSnormSteps;
}

}  // namespace

std::vector<glm::vec4> round_texel(const std::vector<glm::vec4>& lobes, StorageEncoding encoding) {
  std::array<float, kLobeCountMax> amplitudes{};
  for (std::size_t j = 0; j < lobes.size(); ++j) amplitudes[j] = lobes[j].w;
  const bool snorm = encoding == StorageEncoding::kSnorm16;
  if (snorm) round_amplitudes_snorm(amplitudes, static_cast<int>(lobes.size()));
  std::vector<glm::vec4> rounded;
  for (std::size_t j = 0; j < lobes.size(); ++j) {
    const glm::dvec4 lobe(lobes[j]);
    const glm::dvec3 r = lobe.w > 0.0 ? glm::dvec3(lobe) / lobe.w : glm::dvec3(0.0);
    rounded.push_back(snorm ? round_lobe(r, amplitudes[j], bracket_snorm)
                            : round_lobe(r, static_cast<float>(half(amplitudes[j])), bracket_half));
  }
  return rounded;
}

}  // namespace multum::reference
