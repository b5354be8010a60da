// SPDX-License-Identifier: Apache-2.0
// Refines the lobes that EM found towards what is seen: least squares on the texel's normals blurred by highlights.
//
//   minimise  sum_s w_s integral (sum_j a_j gamma_js(h) - 1/N sum_i f_s(h . n_i))^2 dh,   f_s = Blinn-Phong of s
//
// with the sum of amplitudes and the mean normal held. gamma_js is lobe j convolved with f_s. Inner products need no
// directions h: lobe times sample is the lobe convolved with f_s twice, at the sample, and since mean cosines multiply
// under convolution (docs/ALGORITHMS.md, "Shading a filtered lobe") it is the vMF with A = |r_j| c_s^2; lobe times lobe
// has A = |r_j| |r_k| c_s^2. Ours; neither paper fits to what is seen.
//
// A step is damped Gauss-Newton (Levenberg 1944) in (a, two angles, log(1 - |r|)) per lobe. For the matrix alone
// 1/kappa stands in for the sum of the spreads, which is what it is for sharp lobes: it steers, and biases nothing.
//
// One work-item = MULTUM_VECTOR_WIDTH texels, local size 1 or 2 on a CPU; global size slot_count / MULTUM_VECTOR_WIDTH.
//   samples, sample_counts, texel_list   as movmf_em_texels.cl has them
//   level   [lobe][window_rows * width]  read and written: r and amplitude
// Sums run over samples, lobes and BRDFs in their order: the same bytes from both variants. Compute bound: about 55
// operations a lobe and sample, and (4 MULTUM_LOBES)^3 / 6 for the step.

#include "device/level_window.clh"
#include "device/vmf.clh"
#include "shared/movmf_fit.h"
#include "shared/movmf_refine.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif
#ifndef MULTUM_WEIGHTED
#define MULTUM_WEIGHTED 0
#endif
#define SAMPLE_STRIDE ((3 + MULTUM_WEIGHTED) * MULTUM_GROUP)
#define PARAMETERS (4 * MULTUM_LOBES)
// The lower triangle of a symmetric matrix by rows.
#define TRIANGLE(row, column) ((row) * ((row) + 1) / 2 + (column))

__constant float brdf_weights[MULTUM_REFINE_BRDFS] = MULTUM_REFINE_WEIGHTS;
__constant float brdf_spreads[MULTUM_REFINE_BRDFS] = MULTUM_REFINE_SPREADS;

// Unrolled, the loops over lobes and parameters would take a compiler half a minute.
#define ROLLED _Pragma("nounroll")

typedef struct RefinedLobe {
  real_v amplitude, x, y, z, spread;  // direction of unit length; 1 - |r|
  real_v ex, ey, ez, fx, fy, fz;      // two unit tangents
} RefinedLobe;

// A vMF by its mean cosine A: peak exp(-kappa u), up to 1/(2 pi), and what its derivatives need.
typedef struct Blurred {
  real_v kappa, peak;
  real_v peak_slope;   // d log(peak) / d kappa
  real_v kappa_slope;  // d kappa / d A = 1 / (1/kappa^2 - 1/sinh^2 kappa)
} Blurred;

static inline Blurred blurred(real_v mean, real_v spread) {
  Blurred b;
  b.kappa = MAX_V(kappa_of_mean_length(mean, spread), (real_v)(MULTUM_REFINE_KAPPA_MIN));
  const real_v inverse = 1.0f / b.kappa, opposite = exp2_v(b.kappa * (-2.0f * MULTUM_LOG2E));
  const real_v whole = 1.0f / (1.0f - opposite);
  b.peak = b.kappa * whole;
  b.peak_slope = fma(-2.0f * opposite, whole, inverse);
  b.kappa_slope = 1.0f / fma(inverse, inverse, -4.0f * opposite * whole * whole);
  return b;
}

static inline real_v dot_v(real_v ax, real_v ay, real_v az, real_v bx, real_v by, real_v bz) {
  return fma(ax, bx, fma(ay, by, az * bz));
}

// 1 - a . b.
static inline real_v gap_of(real_v ax, real_v ay, real_v az, real_v bx, real_v by, real_v bz) {
  return fma(-ax, bx, fma(-ay, by, fma(-az, bz, (real_v)(1.0f))));
}

// Tangents without a branch or a root (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
static inline void set_tangents(RefinedLobe* lobe) {
  const real_v sign = lobe->z >= 0.0f ? (real_v)(1.0f) : (real_v)(-1.0f);
  const real_v p = -1.0f / (sign + lobe->z), b = lobe->x * lobe->y * p;
  lobe->ex = fma(sign * p, lobe->x * lobe->x, (real_v)(1.0f));
  lobe->ey = sign * b;
  lobe->ez = -sign * lobe->x;
  lobe->fx = b;
  lobe->fy = fma(p, lobe->y * lobe->y, sign);
  lobe->fz = -lobe->y;
}

static void load_lobes(__global const MultumVmfLobe* level, __global const int* texels, size_t level_size,
                       RefinedLobe* lobes) {
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
      const MultumVmfLobe lobe = level[j * level_size + max(texels[lane], 0)];
      x[lane] = lobe.mean_x;
      y[lane] = lobe.mean_y;
      z[lane] = lobe.mean_z;
      a[lane] = lobe.amplitude;
    }
    const real_v rx = LOAD_V(x), ry = LOAD_V(y), rz = LOAD_V(z);
    const real_v length = length_of(rx, ry, rz);
    const int_v directed = length > 1e-6f;
    const real_v inverse = 1.0f / MAX_V(length, (real_v)(1e-6f));
    RefinedLobe* lobe = lobes + j;
    lobe->amplitude = MAX_V(LOAD_V(a), (real_v)(MULTUM_REFINE_AMPLITUDE_MIN));
    lobe->x = directed ? rx * inverse : (real_v)(0.0f);
    lobe->y = directed ? ry * inverse : (real_v)(0.0f);
    lobe->z = directed ? rz * inverse : (real_v)(1.0f);
    lobe->spread = MAX_V(1.0f - length, (real_v)(0.0f));
  }
}

// The samples' part of the gradient of lobe j, and no more: four parameters.
static void subtract_samples(const RefinedLobe* lobe, __global const float* samples, int sample_count,
                             float weight_inverse, real_v* gradient) {
  real_v exponent[MULTUM_REFINE_BRDFS], value[MULTUM_REFINE_BRDFS], turn[MULTUM_REFINE_BRDFS];
  real_v widen[MULTUM_REFINE_BRDFS], widen_peak[MULTUM_REFINE_BRDFS];
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
    const float c2 = 1.0f - brdf_spreads[s];
    const Blurred b = blurred((1.0f - lobe->spread) * c2, fma(lobe->spread, (real_v)(c2), (real_v)(brdf_spreads[s])));
    exponent[s] = b.kappa * -MULTUM_LOG2E;
    value[s] = b.peak * (brdf_weights[s] * weight_inverse);
    turn[s] = value[s] * b.kappa;
    widen[s] = value[s] * b.kappa_slope * -c2 * lobe->spread;
    widen_peak[s] = widen[s] * b.peak_slope;
  }
  const real_v x = lobe->x, y = lobe->y, z = lobe->z;
  real_v sum = (real_v)(0.0f), sum_x = sum, sum_y = sum, sum_z = sum, sum_wider = sum;
  for (int i = 0; i < sample_count; ++i, samples += SAMPLE_STRIDE) {
    const real_v nx = LOAD_V(samples), ny = LOAD_V(samples + MULTUM_GROUP), nz = LOAD_V(samples + 2 * MULTUM_GROUP);
    const real_v u = gap_of(x, y, z, nx, ny, nz);
    real_v v = (real_v)(0.0f), t = v, w = v, p = v;
    _Pragma("unroll") for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
      const real_v e = exp2_v(MIN_V(exponent[s] * u, (real_v)(0.0f)));
      v = fma(value[s], e, v);
      t = fma(turn[s], e, t);
      w = fma(widen[s], e, w);
      p = fma(widen_peak[s], e, p);
    }
#if MULTUM_WEIGHTED
    const real_v weight = LOAD_V(samples + 3 * MULTUM_GROUP);
    v *= weight;
    t *= weight;
    w *= weight;
    p *= weight;
#endif
    sum += v;
    sum_x = fma(t, nx, sum_x);
    sum_y = fma(t, ny, sum_y);
    sum_z = fma(t, nz, sum_z);
    sum_wider += fma(-u, w, p);
  }
  gradient[0] = -sum;
  gradient[1] = -lobe->amplitude * dot_v(sum_x, sum_y, sum_z, lobe->ex, lobe->ey, lobe->ez);
  gradient[2] = -lobe->amplitude * dot_v(sum_x, sum_y, sum_z, lobe->fx, lobe->fy, lobe->fz);
  gradient[3] = -lobe->amplitude * sum_wider;
}

// Lobes j and k <= j: their block of the matrix, and their parts of the gradient.
static void add_pair(const RefinedLobe* lobes, int j, int k, real_v* matrix, real_v* gradient) {
  const RefinedLobe *one = lobes + j, *other = lobes + k;
  const real_v gap =
      j == k ? (real_v)(0.0f) : MAX_V(gap_of(one->x, one->y, one->z, other->x, other->y, other->z), (real_v)(0.0f));
  const real_v spread = fma(-one->spread, other->spread, one->spread + other->spread);
  // Sums over the BRDFs of w V and its derivatives in t = 1 - u, in the spread v = 1/kappa, and in A.
  real_v value = (real_v)(0.0f), by_t = value, by_tt = value, by_v = value, by_vv = value, by_tv = value, by_a = value;
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
    const float c2 = 1.0f - brdf_spreads[s];
    const Blurred b = blurred((1.0f - spread) * c2, fma(spread, (real_v)(c2), (real_v)(brdf_spreads[s])));
    const real_v product = b.peak * exp2_v(b.kappa * gap * -MULTUM_LOG2E) * brdf_weights[s];
    const real_v x = b.kappa * gap, product_kappa = product * b.kappa, product_kappa2 = product_kappa * b.kappa;
    value += product;
    by_t += product_kappa;
    by_tt += product_kappa2;
    by_v = fma(product_kappa, x - 1.0f, by_v);
    by_vv = fma(product_kappa2, fma(x, x - 4.0f, (real_v)(2.0f)), by_vv);
    by_tv = fma(product_kappa2, x - 2.0f, by_tv);
    by_a = fma(product * (b.peak_slope - gap), b.kappa_slope * c2, by_a);
  }
  const real_v aj = one->amplitude, ak = other->amplitude, both = aj * ak;
  const real_v je = dot_v(one->ex, one->ey, one->ez, other->x, other->y, other->z);
  const real_v jf = dot_v(one->fx, one->fy, one->fz, other->x, other->y, other->z);
  const real_v ke = dot_v(other->ex, other->ey, other->ez, one->x, one->y, one->z);
  const real_v kf = dot_v(other->fx, other->fy, other->fz, one->x, one->y, one->z);
  const real_v ee = dot_v(one->ex, one->ey, one->ez, other->ex, other->ey, other->ez);
  const real_v ef = dot_v(one->ex, one->ey, one->ez, other->fx, other->fy, other->fz);
  const real_v fe = dot_v(one->fx, one->fy, one->fz, other->ex, other->ey, other->ez);
  const real_v ff = dot_v(one->fx, one->fy, one->fz, other->fx, other->fy, other->fz);

  gradient[4 * j] = fma(ak, value, gradient[4 * j]);
  gradient[4 * j + 1] = fma(both * by_t, je, gradient[4 * j + 1]);
  gradient[4 * j + 2] = fma(both * by_t, jf, gradient[4 * j + 2]);
  gradient[4 * j + 3] = fma(-one->spread * (1.0f - other->spread), both * by_a, gradient[4 * j + 3]);
  if (j != k) {
    gradient[4 * k] = fma(aj, value, gradient[4 * k]);
    gradient[4 * k + 1] = fma(both * by_t, ke, gradient[4 * k + 1]);
    gradient[4 * k + 2] = fma(both * by_t, kf, gradient[4 * k + 2]);
    gradient[4 * k + 3] = fma(-other->spread * (1.0f - one->spread), both * by_a, gradient[4 * k + 3]);
  }
  const real_v qj = one->spread, qk = other->spread;
  const real_v block[16] = {value,
                            ak * by_t * ke,
                            ak * by_t * kf,
                            ak * qk * by_v,
                            aj * by_t * je,
                            both * fma(by_tt * je, ke, by_t * ee),
                            both * fma(by_tt * je, kf, by_t * ef),
                            both * by_tv * qk * je,
                            aj * by_t * jf,
                            both * fma(by_tt * jf, ke, by_t * fe),
                            both * fma(by_tt * jf, kf, by_t * ff),
                            both * by_tv * qk * jf,
                            aj * qj * by_v,
                            both * by_tv * qj * ke,
                            both * by_tv * qj * kf,
                            both * by_vv * qj * qk};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < (j == k ? row + 1 : 4); ++column)
      matrix[TRIANGLE(4 * j + row, 4 * k + column)] = block[4 * row + column];
}

// What holds the sum of amplitudes and the mean normal: derivatives of (a r, a) of a lobe, [parameter][4].
static void set_moment_rows(const RefinedLobe* lobe, real_v* rows) {
  const real_v length = 1.0f - lobe->spread, turned = lobe->amplitude * length;
  const real_v shortened = -lobe->amplitude * lobe->spread, none = (real_v)(0.0f);
  const real_v values[16] = {length * lobe->x,    length * lobe->y,    length * lobe->z,    (real_v)(1.0f),
                             turned * lobe->ex,   turned * lobe->ey,   turned * lobe->ez,   none,
                             turned * lobe->fx,   turned * lobe->fy,   turned * lobe->fz,   none,
                             shortened * lobe->x, shortened * lobe->y, shortened * lobe->z, none};
  for (int i = 0; i < 16; ++i) rows[i] = values[i];
}

static void add_moments(const RefinedLobe* lobes, const real_v* mean, real_v* matrix, real_v* gradient) {
  real_v rows[PARAMETERS * 4], off[4];
  for (int i = 0; i < 3; ++i) off[i] = -mean[i];
  off[3] = (real_v)(-1.0f);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    set_moment_rows(lobes + j, rows + 16 * j);
    for (int i = 0; i < 4; ++i) off[i] = fma(lobes[j].amplitude, rows[16 * j + i], off[i]);
  }
  ROLLED for (int p = 0; p < PARAMETERS; ++p) {
    const real_v* row = rows + 4 * p;
    const real_v held = fma(row[0], off[0], fma(row[1], off[1], fma(row[2], off[2], row[3] * off[3])));
    gradient[p] = fma((real_v)(MULTUM_REFINE_MOMENT_WEIGHT), held, gradient[p]);
    ROLLED for (int k = 0; k <= p; ++k) {
      const real_v* column = rows + 4 * k;
      const real_v product = fma(row[0], column[0], fma(row[1], column[1], fma(row[2], column[2], row[3] * column[3])));
      matrix[TRIANGLE(p, k)] = fma((real_v)(MULTUM_REFINE_MOMENT_WEIGHT), product, matrix[TRIANGLE(p, k)]);
    }
    matrix[TRIANGLE(p, p)] =
        fma(matrix[TRIANGLE(p, p)], (real_v)(1.0f + MULTUM_REFINE_DAMPING), (real_v)(MULTUM_REFINE_DIAGONAL_MIN));
  }
}

// Solves matrix * step = -gradient by Cholesky; the step is in `gradient` afterwards. The raised diagonal bounds the
// condition of the scaled matrix by 2 PARAMETERS + 1, so that single precision serves and no pivot vanishes.
static void solve(real_v* matrix, real_v* gradient) {
  real_v inverse[PARAMETERS];
  ROLLED for (int j = 0; j < PARAMETERS; ++j) {
    ROLLED for (int i = j; i < PARAMETERS; ++i) {
      real_v sum = matrix[TRIANGLE(i, j)];
      ROLLED for (int k = 0; k < j; ++k) sum = fma(-matrix[TRIANGLE(i, k)], matrix[TRIANGLE(j, k)], sum);
      if (i == j) inverse[j] = 1.0f / sqrt(MAX_V(sum, (real_v)(1e-9f)));
      else matrix[TRIANGLE(i, j)] = sum * inverse[j];
    }
  }
  ROLLED for (int i = 0; i < PARAMETERS; ++i) {
    real_v sum = -gradient[i];
    ROLLED for (int k = 0; k < i; ++k) sum = fma(-matrix[TRIANGLE(i, k)], gradient[k], sum);
    gradient[i] = sum * inverse[i];
  }
  ROLLED for (int i = PARAMETERS - 1; i >= 0; --i) {
    real_v sum = gradient[i];
    ROLLED for (int k = i + 1; k < PARAMETERS; ++k) sum = fma(-matrix[TRIANGLE(k, i)], gradient[k], sum);
    gradient[i] = sum * inverse[i];
  }
}

static void take_step(RefinedLobe* lobes, const real_v* step) {
  real_v total = (real_v)(0.0f);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    RefinedLobe* lobe = lobes + j;
    const real_v a = lobe->amplitude;
    lobe->amplitude = MAX_V(a + step[4 * j], a * MULTUM_REFINE_SHARE_MIN);
    total += lobe->amplitude;
    const real_v e = step[4 * j + 1], f = step[4 * j + 2], turn = sqrt(fma(e, e, f * f));
    const real_v most = sqrt(lobe->spread + MULTUM_REFINE_TURN_MIN);
    const real_v scale = turn > most ? most / MAX_V(turn, (real_v)(1e-12f)) : (real_v)(1.0f);
    const real_v x = fma(scale, fma(e, lobe->ex, f * lobe->fx), lobe->x);
    const real_v y = fma(scale, fma(e, lobe->ey, f * lobe->fy), lobe->y);
    const real_v z = fma(scale, fma(e, lobe->ez, f * lobe->fz), lobe->z);
    const real_v inverse = 1.0f / length_of(x, y, z);  // at least 1: the turn is tangential
    lobe->x = x * inverse;
    lobe->y = y * inverse;
    lobe->z = z * inverse;
    const real_v wider = MIN_V(MAX_V(step[4 * j + 3], (real_v)(-1.0f)), (real_v)(1.0f));
    const real_v spread = lobe->spread * exp2_v(wider * MULTUM_LOG2E);
    lobe->spread = MIN_V(spread, MAX_V(lobe->spread, (real_v)(MULTUM_REFINE_SPREAD_MAX)));
  }
  const real_v inverse = 1.0f / total;
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) lobes[j].amplitude *= inverse;
}

static void mean_of_samples(__global const float* samples, int sample_count, float weight_inverse, real_v* mean) {
  for (int k = 0; k < 3; ++k) mean[k] = (real_v)(0.0f);
  for (int i = 0; i < sample_count; ++i, samples += SAMPLE_STRIDE)
    for (int k = 0; k < 3; ++k) {
#if MULTUM_WEIGHTED
      mean[k] = fma(LOAD_V(samples + k * MULTUM_GROUP), LOAD_V(samples + 3 * MULTUM_GROUP), mean[k]);
#else
      mean[k] += LOAD_V(samples + k * MULTUM_GROUP);
#endif
    }
  for (int k = 0; k < 3; ++k) mean[k] *= weight_inverse;
}

// Every lobe is moved by what the mean normal is off, so that diffuse light stays; one that would be longer than 1 is
// cut.
static void store_lobes(const RefinedLobe* lobes, const real_v* mean, __global MultumVmfLobe* level,
                        __global const int* texels, size_t level_size) {
  real_v off_x = mean[0], off_y = mean[1], off_z = mean[2];
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    const real_v weight = -lobes[j].amplitude * (1.0f - lobes[j].spread);
    off_x = fma(weight, lobes[j].x, off_x);
    off_y = fma(weight, lobes[j].y, off_y);
    off_z = fma(weight, lobes[j].z, off_z);
  }
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    const real_v length = 1.0f - lobes[j].spread;
    const real_v rx = fma(length, lobes[j].x, off_x), ry = fma(length, lobes[j].y, off_y);
    const real_v rz = fma(length, lobes[j].z, off_z);
    const real_v cut = 1.0f / MAX_V(length_of(rx, ry, rz), (real_v)(1.0f));
    float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
    STORE_V(rx * cut, x);
    STORE_V(ry * cut, y);
    STORE_V(rz * cut, z);
    STORE_V(lobes[j].amplitude, a);
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
      if (texels[lane] < 0) continue;
      vstore4((float4)(x[lane], y[lane], z[lane], a[lane]), j * level_size + texels[lane], (__global float*)level);
    }
  }
}

__kernel void movmf_refine(__global const float* restrict samples, __global const int* restrict sample_counts,
                           __global const int* restrict texel_list, __global MultumVmfLobe* restrict level,
                           MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (slot >= fit.slot_count) return;
  const int group = slot / MULTUM_GROUP, sample_count = sample_counts[group];
  __global const float* first = samples + (size_t)group * fit.sample_capacity * SAMPLE_STRIDE + slot % MULTUM_GROUP;
  RefinedLobe lobes[MULTUM_LOBES];
  real_v mean[3], matrix[PARAMETERS * (PARAMETERS + 1) / 2], gradient[PARAMETERS];
  load_lobes(level, texel_list + slot, level_window_size(&fit), lobes);
  mean_of_samples(first, sample_count, fit.total_weight_inverse, mean);
  for (int step = 0; step < MULTUM_REFINE_STEPS; ++step) {
    ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
      set_tangents(lobes + j);
      subtract_samples(lobes + j, first, sample_count, fit.total_weight_inverse, gradient + 4 * j);
    }
    ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) ROLLED for (int k = 0; k <= j; ++k)
        add_pair(lobes, j, k, matrix, gradient);
    add_moments(lobes, mean, matrix, gradient);
    solve(matrix, gradient);
    take_step(lobes, gradient);
  }
  store_lobes(lobes, mean, level, texel_list + slot, level_window_size(&fit));
}
