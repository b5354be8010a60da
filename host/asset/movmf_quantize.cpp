// SPDX-License-Identifier: Apache-2.0
// Rounding of lobes to what is stored. A lobe's spread 1 - |r| decides how wide a highlight is, and |r| is near 1 for
// glossy and flat places: rounding a r_x, a r_y, a r_z and a one by one moves |r| by up to 1/a steps of the grid and
// blurs a roughness-0.1 highlight on a tilted flat to half its peak. So the four are rounded together:
//   1. amplitudes are rounded first, and (snorm16) sum to exactly 1, by largest remainder;
//   2. r is multiplied by the ROUNDED amplitude, so that rounding a costs |r| nothing;
//   3. of the 8 ways to round the three products down or up, the one whose projection on the lobe's own direction is
//      nearest to a |r| is taken; for a single direction (|r| = 1) only those whose projection is at least a are:
//      rounding never adds spread where there was none, and neither does filtering afterwards, since projections of
//      texels that share a direction add up. The length |a r| instead would let a lobe of one step turn by 60 degrees
//      at full length; filtered with its neighbour's lobe of 0.7 that cost 4 % of the peak (QuantizeTest has it).
// Readers clamp |r| to 1.
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/asset/movmf_mipmap.h"
#include "host/base/error.h"
#include "host/base/parallel.h"

namespace multum {
namespace {

constexpr float kSnormSteps = 32767.0f;
// Lobes closer to a single direction than fp32 sums can tell: 8 roundings of 2^-24.
constexpr double kSpreadZero = 5e-7;

// The two neighbours of a value on a grid, at or below and at or above it in magnitude.
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
  // Halfs of one sign are ordered like their bit patterns.
  const bool nearest_is_inner = std::abs(rounded) < std::abs(value);
  const auto bits = nearest.bits();
  other.setBits(static_cast<unsigned short>(nearest_is_inner ? bits + 1 : bits - 1));
  if (nearest_is_inner) return {static_cast<float>(nearest), static_cast<float>(other)};
  return {static_cast<float>(other), static_cast<float>(nearest)};
}

// Steps 2 and 3 for one lobe whose amplitude has been rounded to `a`.
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
  glm::vec3 best(x.outer, y.outer, z.outer);  // never shorter than the target
  double best_cost = HUGE_VAL;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const glm::vec3 candidate((corner & 1u) != 0 ? x.outer : x.inner, (corner & 2u) != 0 ? y.outer : y.inner,
                              (corner & 4u) != 0 ? z.outer : z.inner);
    const double projection = glm::dot(glm::dvec3(candidate), direction);
    if (single_direction && projection < wanted) continue;
    // Single directions: the least turn. Others: the nearest projection; the turn is at most a step either way.
    const double cost = single_direction ? glm::length(glm::dvec3(candidate) - target) : std::abs(projection - wanted);
    if (cost < best_cost) {
      best_cost = cost;
      best = candidate;
    }
  }
  return glm::vec4(best, a);
}

// Step 1, snorm16: whole steps that sum to 32767, the largest remainders rounded up (ties: the lower lobe).
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

void quantize_texel(MovmfLevel& level, std::size_t texel, StorageEncoding encoding) {
  const std::size_t count = level.lobes.size();
  std::array<float, kLobeCountMax> amplitudes{};
  for (std::size_t j = 0; j < count; ++j) amplitudes[j] = level.lobes[j][texel].w;
  if (encoding == StorageEncoding::kSnorm16) round_amplitudes_snorm(amplitudes, static_cast<int>(count));
  for (std::size_t j = 0; j < count; ++j) {
    const glm::dvec4 lobe(level.lobes[j][texel]);
    const glm::dvec3 r = lobe.w > 0.0 ? glm::dvec3(lobe) / lobe.w : glm::dvec3(0.0);
    if (encoding == StorageEncoding::kSnorm16) {
      level.lobes[j][texel] = round_lobe(r, amplitudes[j], bracket_snorm);
    } else {
      level.lobes[j][texel] = round_lobe(r, static_cast<float>(half(amplitudes[j])), bracket_half);
    }
  }
  for (std::vector<glm::vec3>& colours : level.colours) {
    glm::vec3& c = colours[texel];
    c = glm::vec3(static_cast<float>(half(c.x)), static_cast<float>(half(c.y)), static_cast<float>(half(c.z)));
  }
}

}  // namespace

float storage_kappa_max(StorageEncoding encoding) {
  // Measured by the test QuantizeTest.KeepsSpreadUpToKappaMax over random lobes of amplitude 1, tilted up to 60
  // degrees: 1 - |r| changes by 4 % in the median and by 14 % at the 95th percentile at both limits, both in proportion
  // to kappa. A flat lobe has z alone to round: half a step there, 31 % and 24 %, is the worst.
  switch (encoding) {
    case StorageEncoding::kSnorm16: return 20000.0f;
    case StorageEncoding::kHalf: return 1000.0f;
    case StorageEncoding::kFloat: return 1.0e6f;
  }
  return 0.0f;
}

SharpLobes count_sharp_lobes(const MovmfLevel& level, StorageEncoding encoding, int threads) {
  if (encoding == StorageEncoding::kFloat) return {};  // rounds nothing
  // Of less than the least amplitude that snorm16 stores nobody sees the spread.
  constexpr float kAmplitudeMin = 1.0f / kSnormSteps;
  const double spread_min = 1.0 / static_cast<double>(storage_kappa_max(encoding));
  std::vector<SharpLobes> rows(static_cast<std::size_t>(level.height));
  const auto width = static_cast<std::size_t>(level.width);
  for_each_item(level.height, threads, [&](int y) {
    const std::size_t first = static_cast<std::size_t>(y) * width;
    for (const std::vector<glm::vec4>& lobes : level.lobes)
      for (std::size_t i = first; i < first + width; ++i) {
        const glm::dvec4 lobe(lobes[i]);
        if (lobes[i].w < kAmplitudeMin) continue;
        const double spread = 1.0 - glm::length(glm::dvec3(lobe)) / lobe.w;
        if (spread <= kSpreadZero || spread >= spread_min) continue;
        SharpLobes& row = rows[static_cast<std::size_t>(y)];
        ++row.count;
        row.amplitude += lobe.w;
      }
  });
  SharpLobes all;
  for (const SharpLobes& row : rows) {
    all.count += row.count;
    all.amplitude += row.amplitude;
  }
  return all;
}

void quantize_movmf(MovmfMipmap& mipmap, int threads) {
  if (mipmap.encoding == StorageEncoding::kFloat) return;
  for (std::size_t l = static_cast<std::size_t>(mipmap.first_level); l < mipmap.levels.size(); ++l) {
    MovmfLevel& level = mipmap.levels[l];
    const auto width = static_cast<std::size_t>(level.width);
    for_each_item(level.height, threads, [&](int row) {
      const std::size_t first = static_cast<std::size_t>(row) * width;
      for (std::size_t i = first; i < first + width; ++i) quantize_texel(level, i, mipmap.encoding);
    });
  }
}

}  // namespace multum
