// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/yardsticks/em_yardstick.h"

#include <omp.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "kernels/shared/movmf_fit.h"

namespace multum::bench {
namespace {

// Number of lanes per register. For arithmetic, GCC splits wider vectors into registers, but it compares and selects
// lane by lane. With 16 lanes on AVX2, the code in this file therefore took 5.7 times as long as with AVX-512.
#ifdef __AVX512F__
constexpr int kLanes = 16;
#else
constexpr int kLanes = 8;
#endif
static_assert(MULTUM_GROUP % kLanes == 0);

typedef float V __attribute__((vector_size(kLanes * sizeof(float))));
typedef int I __attribute__((vector_size(kLanes * sizeof(int))));

constexpr float kLog2E = 1.44269504f;
constexpr int kChunkSamples = 4096;
constexpr int kSampleFloats = 3 * MULTUM_GROUP;  // x, y and z of each texel in a group

V splat(float x) { return V{} + x; }
V load(const float* p) {
  V v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
V max_v(V a, V b) { return a > b ? a : b; }
V min_v(V a, V b) { return a < b ? a : b; }
I as_int(V v) { return reinterpret_cast<I>(v); }
V as_real(I v) { return reinterpret_cast<V>(v); }

V sqrt_v(V v) {
  for (int i = 0; i < kLanes; ++i) v[i] = std::sqrt(v[i]);
  return v;
}

float sum_v(V v) {
  float sum = 0.0f;
  for (int i = 0; i < kLanes; ++i) sum += v[i];
  return sum;
}

// Flushes subnormal floats to 0 in this thread, until the object goes out of scope. The shares of lobes that are far
// from a normal are subnormal, and Intel's processors compute with subnormal floats a hundred times more slowly. The
// kernels avoid subnormal floats (movmf_em.clh).
class FlushedToZero {
 public:
  FlushedToZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040); }
  ~FlushedToZero() { _mm_setcsr(before_); }
  FlushedToZero(const FlushedToZero&) = delete;
  FlushedToZero& operator=(const FlushedToZero&) = delete;

 private:
  const unsigned before_;
};

V exp2_v(V x) {
  x = max_v(x, splat(-126.0f));
  const V shifted = x + 12582912.0f;
  const V f = x - (shifted - 12582912.0f);
  V p = 1.32764713e-3f * f + 9.67554189e-3f;
  p = p * f + 5.55071346e-2f;
  p = p * f + 2.40221202e-1f;
  p = p * f + 6.93146944e-1f;
  p = p * f + 1.00000012f;
  return as_real(as_int(p) + (as_int(shifted) << 23));
}

V log2_v(V x) {
  const I bits = as_int(x);
  const I exponent = (bits - 0x3f3504f3) >> 23;
  const V m = as_real(bits - (exponent << 23));
  const V t = (m - 1.0f) / (m + 1.0f), t2 = t * t;
  V p = (2.885390f / 9) * t2 + 2.885390f / 7;
  p = p * t2 + 2.885390f / 5;
  p = p * t2 + 2.885390f / 3;
  p = p * t2 + 2.885390082f;
  return p * t + __builtin_convertvector(exponent, V);
}

V kappa_of(V r, V spread) {
  constexpr float kG[] = {74.4787216f,  10.665947f,    -50.2545166f, -11.1790409f, 10.049902f, 3.26216507f,
                          0.535200894f, -0.217628092f, 0.54567641f,  -2.01658821f, 1.79671216f};
  const V y = r - 0.5f;
  V g = splat(kG[0]);
  for (int i = 1; i < 11; ++i) g = g * y + kG[i];
  return r * g / spread;
}

template <int kLobes>
struct Lobes {
  V x[kLobes], y[kLobes], z[kLobes], sharpness[kLobes], log_weight[kLobes];
};
template <int kLobes>
struct Sums {
  V s[kLobes], x[kLobes], y[kLobes], z[kLobes], d[kLobes];
};

template <int kLobes>
void e_step(const Lobes<kLobes>& lobes, V x, V y, V z, Sums<kLobes>& sums) {
  V u[kLobes], e[kLobes], largest = splat(-1e30f), total = splat(0.0f);
  for (int j = 0; j < kLobes; ++j) {
    u[j] = 1.0f - lobes.z[j] * z - lobes.y[j] * y - lobes.x[j] * x;
    e[j] = lobes.log_weight[j] - lobes.sharpness[j] * u[j];
    largest = max_v(largest, e[j]);
  }
  for (int j = 0; j < kLobes; ++j) total += e[j] = exp2_v(e[j] - largest);
  const V scale = 1.0f / total;
  for (int j = 0; j < kLobes; ++j) {
    const V q = e[j] * scale;
    sums.s[j] += q;
    sums.x[j] += q * x;
    sums.y[j] += q * y;
    sums.z[j] += q * z;
    sums.d[j] += q * u[j];
  }
}

struct Moments {
  V x, y, z, spread, amplitude;
};

Moments moments_of(V s, V x, V y, V z, V d, V mu_x, V mu_y, V mu_z, float inverse_count) {
  const V inverse = 1.0f / max_v(s, splat(1e-30f));
  x *= inverse;
  y *= inverse;
  z *= inverse;
  const V length = sqrt_v(max_v(x * x + y * y + z * z, splat(1e-30f)));
  const V length_inverse = 1.0f / length;
  const I alignment_vectors = (length > 1e-6f) & (s * inverse_count > 1e-7f);
  Moments m;
  m.amplitude = s * inverse_count;
  m.x = alignment_vectors ? x * length_inverse : mu_x;
  m.y = alignment_vectors ? y * length_inverse : mu_y;
  m.z = alignment_vectors ? z * length_inverse : mu_z;
  const V dx = m.x - mu_x, dy = m.y - mu_y, dz = m.z - mu_z;
  m.spread = min_v(max_v(d * inverse - length * 0.5f * (dx * dx + dy * dy + dz * dz), splat(0.0f)), splat(1.0f));
  return m;
}

template <int kLobes>
V cap_of(const Sums<kLobes>& sums, float inverse_count, const YardstickLevel& level) {
  V x = splat(0.0f), y = x, z = x;
  for (int j = 0; j < kLobes; ++j) {
    x += sums.x[j];
    y += sums.y[j];
    z += sums.z[j];
  }
  const V length = min_v(sqrt_v(x * x + y * y + z * z) * inverse_count, splat(1.0f));
  return min_v(level.kappa_cap_slope * kappa_of(length, max_v(1.0f - length, splat(1e-6f))) + level.kappa_cap,
               splat(1e6f));
}

template <int kLobes>
void m_step(const Sums<kLobes>& sums, const float* start, V cap, float inverse_count, Lobes<kLobes>& lobes) {
  for (int j = 0; j < kLobes; ++j) {
    const Moments m = moments_of(sums.s[j], sums.x[j], sums.y[j], sums.z[j], sums.d[j], lobes.x[j], lobes.y[j],
                                 lobes.z[j], inverse_count);
    const float* prior = start + (j * MULTUM_START_PLANES + MULTUM_START_PRIOR) * MULTUM_GROUP;
    const V length = 1.0f - m.spread;
    const V vx = m.x * length + load(prior), vy = m.y * length + load(prior + MULTUM_GROUP),
            vz = m.z * length + load(prior + 2 * MULTUM_GROUP);
    const V size = sqrt_v(vx * vx + vy * vy + vz * vz), inverse = 1.0f / max_v(size, splat(1e-6f));
    const I alignment_vectors = size > 1e-6f;
    lobes.x[j] = alignment_vectors ? vx * inverse : m.x;
    lobes.y[j] = alignment_vectors ? vy * inverse : m.y;
    lobes.z[j] = alignment_vectors ? vz * inverse : m.z;
    const V fitted = kappa_of(length, max_v(m.spread, splat(1e-7f)));
    V kappa = m.amplitude > 1e-7f ? fitted : lobes.sharpness[j] * (1.0f / kLog2E);
    kappa = min_v(max_v(kappa, splat(0.05f)), cap);
    lobes.sharpness[j] = kappa * kLog2E;
    lobes.log_weight[j] = log2_v(max_v(m.amplitude, splat(1e-6f)) * kappa / (1.0f - exp2_v(kappa * (-2.0f * kLog2E))));
  }
}

template <int kLobes>
void load_start(const float* start, Lobes<kLobes>& lobes) {
  for (int j = 0; j < kLobes; ++j, start += MULTUM_START_PLANES * MULTUM_GROUP) {
    lobes.x[j] = load(start);
    lobes.y[j] = load(start + MULTUM_GROUP);
    lobes.z[j] = load(start + 2 * MULTUM_GROUP);
    lobes.sharpness[j] = load(start + MULTUM_START_SHARPNESS * MULTUM_GROUP);
    lobes.log_weight[j] = load(start + MULTUM_START_LOG * MULTUM_GROUP);
  }
}

// Fits fine levels with one texel per lane. The texels of a group fill one vector of 16 lanes or two vectors of 8
// lanes. `first_lane` is the number of the vector's first texel in the group.
template <int kLobes>
void fit_lanes(const YardstickLevel& level, int group, int first_lane, float* out) {
  const float inverse_count = 1.0f / static_cast<float>(level.sample_count);
  const float* samples =
      level.samples + static_cast<std::size_t>(group) * static_cast<std::size_t>(level.sample_count) * kSampleFloats +
      first_lane;
  const float* start =
      level.start + static_cast<std::size_t>(group) * kLobes * MULTUM_START_PLANES * MULTUM_GROUP + first_lane;
  Lobes<kLobes> lobes;
  load_start(start, lobes);
  Sums<kLobes> sums = {};
  V cap = splat(level.kappa_cap);
  for (int iteration = 0; iteration < level.iteration_count; ++iteration) {
    sums = {};
    for (int i = 0; i < level.sample_count; ++i) {
      const float* sample = samples + static_cast<std::size_t>(i) * kSampleFloats;
      e_step(lobes, load(sample), load(sample + MULTUM_GROUP), load(sample + 2 * MULTUM_GROUP), sums);
    }
    if (iteration == 0) cap = cap_of(sums, inverse_count, level);
    if (iteration + 1 < level.iteration_count) m_step(sums, start, cap, inverse_count, lobes);
  }
  for (int j = 0; j < kLobes; ++j) {
    const Moments m = moments_of(sums.s[j], sums.x[j], sums.y[j], sums.z[j], sums.d[j], lobes.x[j], lobes.y[j],
                                 lobes.z[j], inverse_count);
    for (int lane = 0; lane < kLanes; ++lane) {
      float* to = out + (static_cast<std::size_t>(j) * static_cast<std::size_t>(level.group_count * MULTUM_GROUP) +
                         static_cast<std::size_t>(group * MULTUM_GROUP + first_lane + lane)) *
                            4;
      const float length = 1.0f - m.spread[lane];
      to[0] = m.x[lane] * length;
      to[1] = m.y[lane] * length;
      to[2] = m.z[lane] * length;
      to[3] = m.amplitude[lane];
    }
  }
}

// Fits coarse levels with one sample per lane. Chunks of rows are summed in parallel, and one M-step follows, with the
// lobes in lane 0.
template <int kLobes>
void fit_texel(const YardstickLevel& level, int texel, float* out) {
  const int side = level.texel_side, rows_per_chunk = std::max(1, kChunkSamples / side);
  const int chunks = (side + rows_per_chunk - 1) / rows_per_chunk;
  const int x0 = texel % level.level_width * side, y0 = texel / level.level_width * side;
  const float inverse_count = 1.0f / (static_cast<float>(side) * static_cast<float>(side));
  // The starting lobes of this texel are copied to all lanes.
  std::vector<float> start(static_cast<std::size_t>(kLobes * MULTUM_START_PLANES * MULTUM_GROUP));
  const float* from =
      level.start + static_cast<std::size_t>(texel / MULTUM_GROUP) * start.size() + texel % MULTUM_GROUP;
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = from[i / MULTUM_GROUP * MULTUM_GROUP];
  Lobes<kLobes> lobes;
  load_start(start.data(), lobes);
  std::vector<Sums<kLobes>> partial(static_cast<std::size_t>(chunks));
  Sums<kLobes> total = {};
  V cap = splat(level.kappa_cap);
  for (int iteration = 0; iteration < level.iteration_count; ++iteration) {
#pragma omp parallel for schedule(dynamic)
    for (int chunk = 0; chunk < chunks; ++chunk) {
      const FlushedToZero flushed;
      Sums<kLobes> sums = {};
      const int last = std::min((chunk + 1) * rows_per_chunk, side);
      for (int row = chunk * rows_per_chunk; row < last; ++row)
        for (int column = 0; column < side; column += kLanes) {
          const std::size_t at = static_cast<std::size_t>(y0 + row) * static_cast<std::size_t>(level.map_width) +
                                 static_cast<std::size_t>(x0 + column);
          e_step(lobes, load(level.plane_x + at), load(level.plane_y + at), load(level.plane_z + at), sums);
        }
      partial[static_cast<std::size_t>(chunk)] = sums;
    }
    total = {};
    for (const Sums<kLobes>& sums : partial)
      for (int j = 0; j < kLobes; ++j) {
        total.s[j] += sum_v(sums.s[j]);
        total.x[j] += sum_v(sums.x[j]);
        total.y[j] += sum_v(sums.y[j]);
        total.z[j] += sum_v(sums.z[j]);
        total.d[j] += sum_v(sums.d[j]);
      }
    if (iteration == 0) cap = cap_of(total, inverse_count, level);
    if (iteration + 1 < level.iteration_count) m_step(total, start.data(), cap, inverse_count, lobes);
  }
  for (int j = 0; j < kLobes; ++j) {
    const Moments m = moments_of(total.s[j], total.x[j], total.y[j], total.z[j], total.d[j], lobes.x[j], lobes.y[j],
                                 lobes.z[j], inverse_count);
    const float length = 1.0f - m.spread[0];
    float* to = out + (static_cast<std::size_t>(j) * static_cast<std::size_t>(level.group_count * MULTUM_GROUP) +
                       static_cast<std::size_t>(texel)) *
                          4;
    to[0] = m.x[0] * length;
    to[1] = m.y[0] * length;
    to[2] = m.z[0] * length;
    to[3] = m.amplitude[0];
  }
}

template <int kLobes>
std::vector<float> fit(const YardstickLevel& level) {
  std::vector<float> out(static_cast<std::size_t>(kLobes) * static_cast<std::size_t>(level.group_count) * 64);
  if (level.samples != nullptr) {
#pragma omp parallel for schedule(dynamic)
    for (int group = 0; group < level.group_count; ++group) {
      const FlushedToZero flushed;
      for (int lane = 0; lane < MULTUM_GROUP; lane += kLanes) fit_lanes<kLobes>(level, group, lane, out.data());
    }
  } else {
    // If there are at least as many texels as threads, each thread fits whole texels. Otherwise threads share a texel's
    // chunks.
#pragma omp parallel for schedule(dynamic) if (level.texel_count >= omp_get_max_threads())
    for (int texel = 0; texel < level.texel_count; ++texel) fit_texel<kLobes>(level, texel, out.data());
  }
  return out;
}

}  // namespace

std::vector<float> MULTUM_YARDSTICK_NAME(const YardstickLevel& level) {
  switch (level.lobe_count) {
    case 4: return fit<4>(level);
    case 6: return fit<6>(level);
    case 8: return fit<8>(level);
    default: return fit<1>(level);
  }
}

}  // namespace multum::bench
