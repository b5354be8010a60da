// SPDX-License-Identifier: Apache-2.0
// Rounds lobes to stored values. The spread 1 - |r| of a lobe decides how wide a highlight is, and |r| is near 1 for
// glossy
// and flat places. If a r_x, a r_y, a r_z and a were rounded independently, |r| would change by up to 1/a steps of the
// grid. On a tilted flat area, this would blur a highlight of roughness 0.1 so much that its peak is halved. Therefore
// the four values are rounded together:
//   1. Amplitudes are rounded first. For snorm16, they sum to exactly 1, by largest remainder.
//   2. r is multiplied by the ROUNDED amplitude, so that rounding a leaves |r| unchanged.
//   3. Each of the three products is rounded down or up, which gives 8 candidates. The chosen one has the projection on
//      the lobe's direction that is closest to a |r|. For a single direction (|r| = 1), the projection must be at least
//      a, so rounding never adds spread. Filtering adds none either, because projections of texels that share a
//      direction add up.
// If candidates were chosen by their length |a r| instead, a lobe with an amplitude of one step could keep its length,
// but turn by 60 degrees. After filtering with a neighbouring lobe of amplitude 0.7, the peak would then be 4 % lower
// (QuantizeTest). Readers clamp |r| to 1.
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/lobe_rounding.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

// A lobe whose spread is below this value (8 roundings of 2^-24) cannot be distinguished from a single direction,
// because sums of 32-bit floats have rounding errors of this size.
constexpr double kSpreadZero = 5e-7;

// The two grid values next to a value. The magnitude of `inner` is at most that of the value, and the magnitude of
// `outer` is at least that of the value.
struct Bracket {
  float inner;
  float outer;
};

float step_value(int step) { return static_cast<float>(step * kSnormStep); }

Bracket bracket_snorm(double value) {
  const double steps = value * kSnormSteps;
  // Lobes have a length of at most 1. NaN and infinity stay unchanged.
  if (!(std::abs(steps) < 1e6)) return {static_cast<float>(value), static_cast<float>(value)};
  const int inner = static_cast<int>(steps);
  const int outer = inner + static_cast<int>(steps > inner) - static_cast<int>(steps < inner);
  return {step_value(inner), step_value(outer)};
}

Bracket bracket_half(double value) {
  const half nearest(static_cast<float>(value));
  const auto rounded = static_cast<double>(static_cast<float>(nearest));
  if (rounded == value) return {static_cast<float>(nearest), static_cast<float>(nearest)};
  half other = nearest;
  // 16-bit floats of the same sign are in the same order as their bit patterns.
  const bool nearest_is_inner = std::abs(rounded) < std::abs(value);
  const auto bits = nearest.bits();
  other.setBits(static_cast<unsigned short>(nearest_is_inner ? bits + 1 : bits - 1));
  if (nearest_is_inner) return {static_cast<float>(nearest), static_cast<float>(other)};
  return {static_cast<float>(other), static_cast<float>(nearest)};
}

// The 8 ways to round. Bit 0 of a corner is set if x is rounded outwards, bit 1 if y is rounded outwards, and bit 2 if
// z is rounded outwards.
struct Corners {
  Bracket x, y, z;
  glm::vec3 at(unsigned corner) const {
    return {(corner & 1u) != 0 ? x.outer : x.inner, (corner & 2u) != 0 ? y.outer : y.inner,
            (corner & 4u) != 0 ? z.outer : z.inner};
  }
};

// Returns the projections of all corners on a direction.
std::array<double, 8> projections(const Corners& corners, const glm::dvec3& direction) {
  const double x[2] = {static_cast<double>(corners.x.inner) * direction.x,
                       static_cast<double>(corners.x.outer) * direction.x};
  const double y[2] = {static_cast<double>(corners.y.inner) * direction.y,
                       static_cast<double>(corners.y.outer) * direction.y};
  const double z[2] = {static_cast<double>(corners.z.inner) * direction.z,
                       static_cast<double>(corners.z.outer) * direction.z};
  const double xy[4] = {x[0] + y[0], x[1] + y[0], x[0] + y[1], x[1] + y[1]};
  return {xy[0] + z[0], xy[1] + z[0], xy[2] + z[0], xy[3] + z[0],
          xy[0] + z[1], xy[1] + z[1], xy[2] + z[1], xy[3] + z[1]};
}

// Returns the corner whose projection is closest, or the first of them if several are equally close. The direction
// turns by at most one step.
unsigned nearest_corner(const std::array<double, 8>& projection, double wanted) {
  unsigned best = 7;
  double best_cost = HUGE_VAL;
  for (unsigned corner = 0; corner < 8; ++corner) {
    const double cost = std::abs(projection[corner] - wanted);
    best = cost < best_cost ? corner : best;
    best_cost = std::min(cost, best_cost);
  }
  return best;
}

// Used for single directions. Among the corners that are not shorter, returns the one that changes the direction least.
// The corner with x, y and z all rounded outwards is never shorter.
unsigned least_turned_corner(const Corners& corners, const std::array<double, 8>& projection, double wanted,
                             const glm::dvec3& target) {
  unsigned best = 7;
  double best_cost = HUGE_VAL;
  for (unsigned corner = 0; corner < 8; ++corner) {
    if (projection[corner] < wanted) continue;
    const double cost = glm::length(glm::dvec3(corners.at(corner)) - target);
    if (cost < best_cost) {
      best_cost = cost;
      best = corner;
    }
  }
  return best;
}

// Applies steps 2 and 3 to one lobe, stored as a (r, 1). Its amplitude is already rounded to `a`.
template <typename BracketOf>
glm::vec4 round_lobe(const glm::vec4& stored, float a, const BracketOf& bracket_of) {
  if (a <= 0.0f) return glm::vec4(0.0f);
  const glm::dvec4 lobe(stored);
  const glm::dvec3 r = lobe.w > 0.0 ? glm::dvec3(lobe) / lobe.w : glm::dvec3(0.0);
  const double length = glm::length(r);
  const bool single_direction = length >= 1.0 - kSpreadZero;
  const auto amplitude = static_cast<double>(a);
  const glm::dvec3 target = r * (single_direction ? amplitude / length : amplitude);
  const Corners corners{bracket_of(target.x), bracket_of(target.y), bracket_of(target.z)};
  const double wanted = single_direction ? amplitude : amplitude * length;
  const glm::dvec3 direction = length > 0.0 ? r / length : glm::dvec3(0.0);
  const std::array<double, 8> projection = projections(corners, direction);
  return glm::vec4(corners.at(single_direction ? least_turned_corner(corners, projection, wanted, target)
                                               : nearest_corner(projection, wanted)),
                   a);
}

// Values of neighbouring texels, arranged so that the compiler vectorizes the loops. All operations are the same as in
// round_lobe(). At level 1 of a map with four lobes, most lobes are single directions or empty. Therefore the lobes of
// each kind are gathered and rounded separately.
using Block = std::array<double, kRoundingBlock>;

// Lobes of one kind: their mean vectors r, the lengths of r, the rounded amplitudes, and the positions in the block.
struct Gathered {
  Block x, y, z, length, amplitude;
  std::array<std::size_t, kRoundingBlock> index;
  std::size_t count = 0;

  void add(const Gathered& from, std::size_t i) {
    x[count] = from.x[i];
    y[count] = from.y[i];
    z[count] = from.z[i];
    length[count] = from.length[i];
    amplitude[count] = from.amplitude[i];
    index[count++] = from.index[i];
  }
};

// Computes the two values of the snorm16 grid next to `value`, for |value| <= 1.
inline void bracket_steps(double value, double& inner, double& outer) {
  const double steps = value * kSnormSteps;
  const double down = static_cast<double>(static_cast<int>(steps));
  const double up = down + (steps > down ? 1.0 : 0.0) - (steps < down ? 1.0 : 0.0);
  inner = static_cast<double>(static_cast<float>(down * kSnormStep));
  outer = static_cast<double>(static_cast<float>(up * kSnormStep));
}

// Applies steps 2 and 3, after which r is the stored value. This function is inlined into each vector clone below.
template <bool kSingleDirection>
[[gnu::always_inline]] inline void round_gathered(Gathered& lobes) {
  const std::size_t count = lobes.count;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = lobes.amplitude[i], length = lobes.length[i];
    const double wanted = kSingleDirection ? a : a * length, scale = kSingleDirection ? a / length : a;
    const double tx = lobes.x[i] * scale, ty = lobes.y[i] * scale, tz = lobes.z[i] * scale;
    double x0, x1, y0, y1, z0, z1;
    bracket_steps(tx, x0, x1);
    bracket_steps(ty, y0, y1);
    bracket_steps(tz, z0, z1);
    const double divisor = length > 0.0 ? length : 1.0;
    const double dx = lobes.x[i] / divisor, dy = lobes.y[i] / divisor, dz = lobes.z[i] / divisor;
    const double px0 = x0 * dx, px1 = x1 * dx, py0 = y0 * dy, py1 = y1 * dy, pz0 = z0 * dz, pz1 = z1 * dz;
    double best = 7.0, best_cost = HUGE_VAL;
    const auto offer = [&](double corner, double projection, double cx, double cy, double cz) {
      double cost = std::abs(projection - wanted);
      if constexpr (kSingleDirection) {
        const double turn = std::sqrt((cx - tx) * (cx - tx) + (cy - ty) * (cy - ty) + (cz - tz) * (cz - tz));
        cost = projection < wanted ? HUGE_VAL : turn;
      }
      best = cost < best_cost ? corner : best;
      best_cost = cost < best_cost ? cost : best_cost;
    };
    offer(0.0, px0 + py0 + pz0, x0, y0, z0);
    offer(1.0, px1 + py0 + pz0, x1, y0, z0);
    offer(2.0, px0 + py1 + pz0, x0, y1, z0);
    offer(3.0, px1 + py1 + pz0, x1, y1, z0);
    offer(4.0, px0 + py0 + pz1, x0, y0, z1);
    offer(5.0, px1 + py0 + pz1, x1, y0, z1);
    offer(6.0, px0 + py1 + pz1, x0, y1, z1);
    offer(7.0, px1 + py1 + pz1, x1, y1, z1);
    // Extracts the bits of `best` with operations on doubles.
    const double low = best >= 4.0 ? best - 4.0 : best, lowest = low >= 2.0 ? low - 2.0 : low;
    lobes.z[i] = best >= 4.0 ? z1 : z0;
    lobes.y[i] = low >= 2.0 ? y1 : y0;
    lobes.x[i] = lowest >= 1.0 ? x1 : x0;
  }
}

MULTUM_VECTOR_CLONES
void round_single(Gathered& lobes) { round_gathered<true>(lobes); }
MULTUM_VECTOR_CLONES
void round_spread(Gathered& lobes) { round_gathered<false>(lobes); }

// Replaces a r by r.
MULTUM_VECTOR_CLONES
void divide(Gathered& lobes, const Block& divisor) {
  const std::size_t count = lobes.count;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = lobes.x[i] / divisor[i], y = lobes.y[i] / divisor[i], z = lobes.z[i] / divisor[i];
    lobes.x[i] = x;
    lobes.y[i] = y;
    lobes.z[i] = z;
    lobes.length[i] = std::sqrt(x * x + y * y + z * z);
  }
}

// Vector instructions can round a small negative value to -0, where scalar code gives 0. Adding 0 makes both equal.
void scatter(const Gathered& rounded, glm::vec4* lobes) {
  for (std::size_t i = 0; i < rounded.count; ++i)
    lobes[rounded.index[i]] = {static_cast<float>(rounded.x[i]) + 0.0f, static_cast<float>(rounded.y[i]) + 0.0f,
                               static_cast<float>(rounded.z[i]) + 0.0f, static_cast<float>(rounded.amplitude[i])};
}

// Applies steps 2 and 3 to a block of one lobe.
void round_block_snorm(glm::vec4* lobes, const double* amplitudes, std::size_t count) {
  Gathered all, single, spread;
  Block divisor;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec4& lobe = lobes[i];
    if (!(amplitudes[i] > 0.0 && lobe.w > 0.0f)) {
      lobes[i] = round_lobe(lobe, static_cast<float>(amplitudes[i]), bracket_snorm);
      continue;
    }
    all.x[all.count] = static_cast<double>(lobe.x);
    all.y[all.count] = static_cast<double>(lobe.y);
    all.z[all.count] = static_cast<double>(lobe.z);
    all.amplitude[all.count] = amplitudes[i];
    divisor[all.count] = static_cast<double>(lobe.w);
    all.index[all.count++] = i;
  }
  divide(all, divisor);
  for (std::size_t i = 0; i < all.count; ++i) {
    glm::vec4& lobe = lobes[all.index[i]];
    if (all.length[i] < 1.0 - kSpreadZero) spread.add(all, i);
    else if (all.length[i] < 2.0) single.add(all, i);
    else
      lobe = round_lobe(lobe, static_cast<float>(all.amplitude[i]), bracket_snorm);  // the lobe is not finite, or its
                                                                                     // mean is zero
  }
  round_single(single);
  round_spread(spread);
  scatter(single, lobes);
  scatter(spread, lobes);
}

void round_lobes(glm::vec4* lobes, const double* amplitudes, std::size_t count, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) return round_block_snorm(lobes, amplitudes, count);
  for (std::size_t i = 0; i < count; ++i)
    lobes[i] = round_lobe(lobes[i], static_cast<float>(amplitudes[i]), bracket_half);
}

// Returns whether a lobe is too sharp for its spread to be kept. Single directions do not count.
bool is_sharp(const glm::vec4& lobe, double spread_min) {
  const double spread = 1.0 - glm::length(glm::dvec3(lobe)) / static_cast<double>(lobe.w);
  return spread > kSpreadZero && spread < spread_min;
}

}  // namespace

float storage_kappa_max(StorageEncoding encoding) {
  // QuantizeTest.KeepsSpreadUpToKappaMax measures this over random lobes of amplitude 1, tilted up to 60 degrees. At
  // both limits, 1 - |r| changes by 4 % in the median and by 14 % at the 95th percentile. The change is proportional to
  // kappa. The worst case is a flat lobe, where only z is rounded. Half a step then changes 1 - |r| by 31 % for snorm16
  // and by 24 % for 16-bit floats.
  switch (encoding) {
    case StorageEncoding::kSnorm16: return 20000.0f;
    case StorageEncoding::kHalf: return 1000.0f;
    case StorageEncoding::kFloat: return 1.0e6f;
  }
  return 0.0f;
}

SharpLobes count_sharp_lobes(const MovmfLevel& level, StorageEncoding encoding, int threads) {
  if (encoding == StorageEncoding::kFloat) return {};  // floats are not rounded
  return count_lobes(level, threads, is_sharp, 1.0 / static_cast<double>(storage_kappa_max(encoding)));
}

void quantize_movmf(MovmfLevel& rows, StorageEncoding encoding, int threads) {
  round_rows(rows, encoding, threads, round_lobes);
}

void quantize_movmf(MovmfMipmap& mipmap, int threads) {
  const LobeFamily& family = lobe_family(mipmap.header.representation);
  for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < mipmap.levels.size(); ++l) {
    MovmfLevel& level = mipmap.levels[l];
    if (l > 0) {
      family.quantize(level, mipmap.header.encoding, threads);
      continue;
    }
    for_each_row_band(level.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
      MovmfFinest rows =
          finest_of(level, row_begin, row_end - row_begin, mipmap.header.representation, mipmap.header.has_roughness);
      quantize_movmf(rows, mipmap.header.encoding, 1);
      expand_into(rows, level, row_begin, 1);
    });
  }
}

}  // namespace multum
