// SPDX-License-Identifier: Apache-2.0
// Refines the lobes that EM found, to lower the error of highlights. The highlights of the lobes are fitted by least
// squares to the exact highlights of the texel's normals:
//
//   minimise  sum_s w_s integral (sum_j a_j gamma_js(h) - 1/N sum_i f_s(h . n_i))^2 dh,   f_s = Blinn-Phong of s
//
// This is the energy at the texel's centre. Another weighted term keeps the mean normal close to the exact one.
// Pictures also show places between centres, so one more term is added for each of the four adjacent texels. This term
// averages the texel's refined lobes with the neighbour's EM lobes, as a texture filter does. The highlights of these
// averages should equal the mean of the highlights of both texels' EM lobes. A texel reads EM's lobes of its neighbours
// and never the output of this kernel, so texels are independent of one another.
//
// gamma_js is lobe j convolved with f_s. Inner products need no sampled directions h. The inner product of a lobe and a
// sample is the value, at the sample, of the lobe convolved twice with f_s. The mean cosine of a convolution is the
// product of the mean cosines (docs/contributing/ALGORITHMS.md, "Shading a filtered lobe"), so this product is the vMF
// with A = |r_j| c_s^2. The product of two lobes has A = |r_j| |r_k| c_s^2. This refinement is not from a paper;
// neither paper fits lobes to highlights.
//
// A step is damped Gauss-Newton (Levenberg 1944) in (a, two angles, log(1 - |r|)) per lobe. A step that does not lower
// the energy is undone, and a quarter of it is tried. Only the matrix is approximate: 1/kappa replaces the sum of the
// spreads, which is the same for sharp lobes. This approximation affects the steps, but not the minimum.
//
// Squared errors give most weight to directions with many normals and little weight to dim ones. Therefore the texel's
// highlights are compared at the end. EM's lobes are kept if their relative L1 error over some half vectors is clearly
// lower than the error of the refined lobes.
//
// One work-item handles MULTUM_VECTOR_WIDTH texels. The local size is 1 or 2 on a CPU, and the global size is
// slot_count / MULTUM_VECTOR_WIDTH.
//   samples, sample_counts, texel_list   as in movmf_em_texels.cl
//   level     [lobe][window_rows * width]  output of EM: r and amplitude, of the texels and of their neighbours
//   refined   [lobe][window_rows * width]  written for the texels of the list
// Sums run over samples, lobes and BRDFs in their order, so both variants write the same bytes. Compute bound: about 55
// operations per lobe and sample, some 300 for each of 10 MULTUM_LOBES^2 pairs of lobes, and (4 MULTUM_LOBES)^3 / 6 for
// the step.

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
// The index into the lower triangle of a symmetric matrix, which is stored by rows.
#define TRIANGLE(row, column) ((row) * ((row) + 1) / 2 + (column))

__constant float brdf_weights[MULTUM_REFINE_BRDFS] = MULTUM_REFINE_WEIGHTS;
__constant float brdf_exponents[MULTUM_REFINE_BRDFS] = MULTUM_REFINE_EXPONENTS;
__constant float look_xy[MULTUM_REFINE_LOOKS][2] = MULTUM_REFINE_LOOK_XY;
__constant float brdf_spreads[MULTUM_REFINE_BRDFS] = MULTUM_REFINE_SPREADS;

// Prevents the compiler from unrolling loops over lobes and parameters. If they were unrolled, compiling would take
// half a minute.
#define ROLLED _Pragma("nounroll")

typedef struct RefinedLobe {
  real_v amplitude, x, y, z, spread;  // direction of unit length; spread 1 - |r|
  real_v ex, ey, ez, fx, fy, fz;      // two unit tangents
  real_v widening;                    // derivative of the spread with respect to the fourth parameter
} RefinedLobe;

// A vMF with mean cosine A, which is `peak * exp(-kappa * u)` without the common 1/(2 pi), and the terms of its
// derivatives.
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

// Returns 1 - a . b.
static inline real_v gap_of(real_v ax, real_v ay, real_v az, real_v bx, real_v by, real_v bz) {
  return fma(-ax, bx, fma(-ay, by, fma(-az, bz, (real_v)(1.0f))));
}

// Computes tangents without a branch or a square root (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
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

// Sets a lobe from r and an amplitude, with the derivatives with respect to the parameters of a step.
static void set_lobe(RefinedLobe* lobe, real_v rx, real_v ry, real_v rz, real_v amplitude) {
  const real_v length = length_of(rx, ry, rz);
  const int_v directed = length > 1e-6f;
  const real_v inverse = 1.0f / MAX_V(length, (real_v)(1e-6f));
  lobe->amplitude = MAX_V(amplitude, (real_v)(MULTUM_REFINE_AMPLITUDE_MIN));
  lobe->x = directed ? rx * inverse : (real_v)(0.0f);
  lobe->y = directed ? ry * inverse : (real_v)(0.0f);
  lobe->z = directed ? rz * inverse : (real_v)(1.0f);
  lobe->spread = MAX_V(1.0f - length, (real_v)(0.0f));
  lobe->widening = lobe->spread;
  set_tangents(lobe);
}

static void load_lobes(__global const MultumVmfLobe* level, const int* texels, size_t level_size, RefinedLobe* lobes) {
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
      const MultumVmfLobe lobe = level[j * level_size + max(texels[lane], 0)];
      x[lane] = lobe.mean_x;
      y[lane] = lobe.mean_y;
      z[lane] = lobe.mean_z;
      a[lane] = lobe.amplitude;
    }
    set_lobe(lobes + j, LOAD_V(x), LOAD_V(y), LOAD_V(z), LOAD_V(a));
  }
}

// Sets lobe j's four entries of the gradient to the part from the samples. Returns the samples' part of the energy.
static real_v subtract_samples(const RefinedLobe* lobe, __global const float* samples, int sample_count,
                               float weight_inverse, real_v* gradient) {
  real_v exponent[MULTUM_REFINE_BRDFS], value[MULTUM_REFINE_BRDFS], turn[MULTUM_REFINE_BRDFS];
  real_v widen[MULTUM_REFINE_BRDFS], widen_peak[MULTUM_REFINE_BRDFS];
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
    const float c2 = 1.0f - brdf_spreads[s];
    const Blurred b = blurred((1.0f - lobe->spread) * c2, fma(lobe->spread, (real_v)(c2), (real_v)(brdf_spreads[s])));
    exponent[s] = b.kappa * -MULTUM_LOG2E;
    value[s] = b.peak * (brdf_weights[s] * weight_inverse);
    turn[s] = value[s] * b.kappa;
    widen[s] = value[s] * b.kappa_slope * -c2 * lobe->widening;
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
  return -2.0f * lobe->amplitude * sum;
}

// Computes the products of the derivatives of two lobes, or of one lobe with itself. The products are indexed
// [parameter of one][parameter of the other]. Adds their part of the gradient. Returns their part of the energy.
static real_v pair_products(const RefinedLobe* one, const RefinedLobe* other, bool same, real_v* block,
                            real_v* gradient, real_v* gradient_other) {
  const real_v gap =
      same ? (real_v)(0.0f) : MAX_V(gap_of(one->x, one->y, one->z, other->x, other->y, other->z), (real_v)(0.0f));
  const real_v spread = fma(-one->spread, other->spread, one->spread + other->spread);
  // Sums over the BRDFs of w V, and of the derivatives of w V with respect to t = 1 - u, the spread v = 1/kappa, and A.
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

  gradient[0] = fma(ak, value, gradient[0]);
  gradient[1] = fma(both * by_t, je, gradient[1]);
  gradient[2] = fma(both * by_t, jf, gradient[2]);
  gradient[3] = fma(-one->widening * (1.0f - other->spread), both * by_a, gradient[3]);
  if (!same) {
    gradient_other[0] = fma(aj, value, gradient_other[0]);
    gradient_other[1] = fma(both * by_t, ke, gradient_other[1]);
    gradient_other[2] = fma(both * by_t, kf, gradient_other[2]);
    gradient_other[3] = fma(-other->widening * (1.0f - one->spread), both * by_a, gradient_other[3]);
  }
  const real_v products[16] = {value,
                               ak * by_t * ke,
                               ak * by_t * kf,
                               ak * other->widening * by_v,
                               aj * by_t * je,
                               both * fma(by_tt * je, ke, by_t * ee),
                               both * fma(by_tt * je, kf, by_t * ef),
                               both * by_tv * other->widening * je,
                               aj * by_t * jf,
                               both * fma(by_tt * jf, ke, by_t * fe),
                               both * fma(by_tt * jf, kf, by_t * ff),
                               both * by_tv * other->widening * jf,
                               aj * one->widening * by_v,
                               both * by_tv * one->widening * ke,
                               both * by_tv * one->widening * kf,
                               both * by_vv * one->widening * other->widening};
  for (int i = 0; i < 16; ++i) block[i] = products[i];
  return (same ? 1.0f : 2.0f) * both * value;
}

// Sets the matrix and adds the gradient of all pairs of lobes. Returns their part of the energy.
static real_v add_pairs(const RefinedLobe* lobes, real_v* matrix, real_v* gradient) {
  real_v energy = (real_v)(0.0f);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) ROLLED for (int k = 0; k <= j; ++k) {
    real_v block[16];
    energy += pair_products(lobes + j, lobes + k, j == k, block, gradient + 4 * j, gradient + 4 * k);
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < (j == k ? row + 1 : 4); ++column)
        matrix[TRIANGLE(4 * j + row, 4 * k + column)] = block[4 * row + column];
  }
  return energy;
}

// Adds the part of one lobe's gradient that comes from the target lobes `shown`, whose amplitudes are multiplied by
// `share`. Returns the part of the energy that comes from them.
static real_v subtract_lobes(const RefinedLobe* lobe, const RefinedLobe* shown, float share, real_v* gradient) {
  real_v energy = (real_v)(0.0f);
  ROLLED for (int k = 0; k < MULTUM_LOBES; ++k) {
    const RefinedLobe* other = shown + k;
    const real_v gap = MAX_V(gap_of(lobe->x, lobe->y, lobe->z, other->x, other->y, other->z), (real_v)(0.0f));
    const real_v spread = fma(-lobe->spread, other->spread, lobe->spread + other->spread);
    real_v value = (real_v)(0.0f), by_t = value, by_a = value;
    for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
      const float c2 = 1.0f - brdf_spreads[s];
      const Blurred b = blurred((1.0f - spread) * c2, fma(spread, (real_v)(c2), (real_v)(brdf_spreads[s])));
      const real_v product = b.peak * exp2_v(b.kappa * gap * -MULTUM_LOG2E) * brdf_weights[s];
      value += product;
      by_t = fma(product, b.kappa, by_t);
      by_a = fma(product * (b.peak_slope - gap), b.kappa_slope * c2, by_a);
    }
    const real_v a = share * other->amplitude, both = a * lobe->amplitude;
    gradient[0] = fma(-a, value, gradient[0]);
    gradient[1] = fma(-both * by_t, dot_v(lobe->ex, lobe->ey, lobe->ez, other->x, other->y, other->z), gradient[1]);
    gradient[2] = fma(-both * by_t, dot_v(lobe->fx, lobe->fy, lobe->fz, other->x, other->y, other->z), gradient[2]);
    gradient[3] = fma(lobe->widening * (1.0f - other->spread), both * by_a, gradient[3]);
    energy = fma(-2.0f * both, value, energy);
  }
  return energy;
}

// Averages two lobes as texture filters do. by_one[row][column] is the derivative of parameter `row` of the averaged
// lobe with respect to parameter `column` of lobe `one`. The averaged lobe's fourth parameter is its spread, which may
// be 0.
static void pool(const RefinedLobe* one, const RefinedLobe* other, RefinedLobe* lobe, real_v* by_one) {
  const real_v amplitude = 0.5f * (one->amplitude + other->amplitude), inverse = 1.0f / amplitude;
  const real_v length_one = 1.0f - one->spread;
  const real_v share_one = 0.5f * one->amplitude * inverse * length_one;
  const real_v share_other = 0.5f * other->amplitude * inverse * (1.0f - other->spread);
  set_lobe(lobe, fma(share_one, one->x, share_other * other->x), fma(share_one, one->y, share_other * other->y),
           fma(share_one, one->z, share_other * other->z), amplitude);
  lobe->widening = (real_v)(1.0f);
  const real_v length = 1.0f - lobe->spread, turn_inverse = 1.0f / MAX_V(length, (real_v)(MULTUM_REFINE_LENGTH_MIN));
  // Half of the derivatives of `a * r`, divided by the amplitude of the averaged lobe. The effect of a larger amplitude
  // on r is subtracted.
  const real_v turned = 0.5f * one->amplitude * inverse * length_one;
  const real_v shortened = -0.5f * one->amplitude * inverse * one->widening, grown = 0.5f * inverse;
  const real_v moved[12] = {grown * fma(length_one, one->x, -length * lobe->x),
                            grown * fma(length_one, one->y, -length * lobe->y),
                            grown * fma(length_one, one->z, -length * lobe->z),
                            turned * one->ex,
                            turned * one->ey,
                            turned * one->ez,
                            turned * one->fx,
                            turned * one->fy,
                            turned * one->fz,
                            shortened * one->x,
                            shortened * one->y,
                            shortened * one->z};
  for (int column = 0; column < 4; ++column) {
    const real_v* m = moved + 3 * column;
    by_one[column] = column == 0 ? (real_v)(0.5f) : (real_v)(0.0f);
    by_one[4 + column] = turn_inverse * dot_v(lobe->ex, lobe->ey, lobe->ez, m[0], m[1], m[2]);
    by_one[8 + column] = turn_inverse * dot_v(lobe->fx, lobe->fy, lobe->fz, m[0], m[1], m[2]);
    by_one[12 + column] = -dot_v(lobe->x, lobe->y, lobe->z, m[0], m[1], m[2]);
  }
}

// Adds the terms for the point midway to an adjacent texel. `start` and `beside` are the EM lobes of the two texels.
// Returns the energy.
static real_v add_midway(const RefinedLobe* lobes, const RefinedLobe* start, const RefinedLobe* beside, real_v weight,
                         real_v* matrix, real_v* gradient) {
  RefinedLobe mixed[MULTUM_LOBES];
  real_v by_lobe[16 * MULTUM_LOBES], mixed_gradient[PARAMETERS], energy = (real_v)(0.0f);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    pool(lobes + j, beside + j, mixed + j, by_lobe + 16 * j);
    for (int i = 0; i < 4; ++i) mixed_gradient[4 * j + i] = (real_v)(0.0f);
    energy += subtract_lobes(mixed + j, start, 0.5f, mixed_gradient + 4 * j);
    energy += subtract_lobes(mixed + j, beside, 0.5f, mixed_gradient + 4 * j);
  }
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) ROLLED for (int k = 0; k <= j; ++k) {
    real_v block[16], right_done[16];
    energy += pair_products(mixed + j, mixed + k, j == k, block, mixed_gradient + 4 * j, mixed_gradient + 4 * k);
    const real_v *left = by_lobe + 16 * j, *right = by_lobe + 16 * k;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 4; ++column) {
        real_v sum = block[4 * row] * right[column];
        for (int i = 1; i < 4; ++i) sum = fma(block[4 * row + i], right[4 * i + column], sum);
        right_done[4 * row + column] = sum;
      }
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < (j == k ? row + 1 : 4); ++column) {
        real_v sum = left[row] * right_done[column];
        for (int i = 1; i < 4; ++i) sum = fma(left[4 * i + row], right_done[4 * i + column], sum);
        const int at = TRIANGLE(4 * j + row, 4 * k + column);
        matrix[at] = fma(weight, sum, matrix[at]);
      }
  }
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) for (int column = 0; column < 4; ++column) {
    const real_v* by = by_lobe + 16 * j + column;
    real_v sum = by[0] * mixed_gradient[4 * j];
    for (int i = 1; i < 4; ++i) sum = fma(by[4 * i], mixed_gradient[4 * j + i], sum);
    gradient[4 * j + column] = fma(weight, sum, gradient[4 * j + column]);
  }
  return weight * energy;
}

// Computes the derivatives of (a r, a) of a lobe, [parameter][4], for the term that keeps the mean normal and the sum
// of amplitudes.
static void set_moment_rows(const RefinedLobe* lobe, real_v* rows) {
  const real_v length = 1.0f - lobe->spread, turned = lobe->amplitude * length;
  const real_v shortened = -lobe->amplitude * lobe->widening, none = (real_v)(0.0f);
  const real_v values[16] = {length * lobe->x,    length * lobe->y,    length * lobe->z,    (real_v)(1.0f),
                             turned * lobe->ex,   turned * lobe->ey,   turned * lobe->ez,   none,
                             turned * lobe->fx,   turned * lobe->fy,   turned * lobe->fz,   none,
                             shortened * lobe->x, shortened * lobe->y, shortened * lobe->z, none};
  for (int i = 0; i < 16; ++i) rows[i] = values[i];
}

// Adds the term for the moments. This term is added after the diagonal is raised. Otherwise the damping would grow with
// this term and keep lobes from moving. Returns the energy.
static real_v add_moments(const RefinedLobe* lobes, const real_v* mean, real_v* matrix, real_v* gradient) {
  real_v rows[PARAMETERS * 4], off[4];
  for (int i = 0; i < 3; ++i) off[i] = -mean[i];
  off[3] = (real_v)(-1.0f);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    set_moment_rows(lobes + j, rows + 16 * j);
    for (int i = 0; i < 4; ++i) off[i] = fma(lobes[j].amplitude, rows[16 * j + i], off[i]);
  }
  ROLLED for (int p = 0; p < PARAMETERS; ++p) {
    const real_v* row = rows + 4 * p;
    matrix[TRIANGLE(p, p)] =
        fma(matrix[TRIANGLE(p, p)], (real_v)(1.0f + MULTUM_REFINE_DAMPING), (real_v)(MULTUM_REFINE_DIAGONAL_MIN));
    const real_v held = fma(row[0], off[0], fma(row[1], off[1], fma(row[2], off[2], row[3] * off[3])));
    gradient[p] = fma((real_v)(MULTUM_REFINE_MOMENT_WEIGHT), held, gradient[p]);
    ROLLED for (int k = 0; k <= p; ++k) {
      const real_v* column = rows + 4 * k;
      const real_v product = fma(row[0], column[0], fma(row[1], column[1], fma(row[2], column[2], row[3] * column[3])));
      matrix[TRIANGLE(p, k)] = fma((real_v)(MULTUM_REFINE_MOMENT_WEIGHT), product, matrix[TRIANGLE(p, k)]);
    }
  }
  const real_v squares = fma(off[0], off[0], fma(off[1], off[1], fma(off[2], off[2], off[3] * off[3])));
  return MULTUM_REFINE_MOMENT_WEIGHT * squares;
}

// Solves matrix * step = -gradient by Cholesky and writes the step to `gradient`. The raised diagonal keeps pivots well
// above rounding errors, so single precision is enough.
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
    const real_v inverse = 1.0f / length_of(x, y, z);  // the length is at least 1, because the turn is tangential
    lobe->x = x * inverse;
    lobe->y = y * inverse;
    lobe->z = z * inverse;
    const real_v wider = MIN_V(MAX_V(step[4 * j + 3], (real_v)(-1.0f)), (real_v)(1.0f));
    const real_v spread = lobe->spread * exp2_v(wider * MULTUM_LOG2E);
    lobe->spread = MIN_V(spread, MAX_V(lobe->spread, (real_v)(MULTUM_REFINE_SPREAD_MAX)));
    lobe->widening = lobe->spread;
    set_tangents(lobe);
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

static void store_lobes(const RefinedLobe* lobes, __global MultumVmfLobe* refined, __global const int* texels,
                        size_t level_size) {
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    const real_v length = 1.0f - lobes[j].spread;
    float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
    STORE_V(length * lobes[j].x, x);
    STORE_V(length * lobes[j].y, y);
    STORE_V(length * lobes[j].z, z);
    STORE_V(lobes[j].amplitude, a);
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
      if (texels[lane] < 0) continue;
      vstore4((float4)(x[lane], y[lane], z[lane], a[lane]), j * level_size + texels[lane], (__global float*)refined);
    }
  }
}

// Computes the brightness of the Blinn-Phong highlight of each exponent over the samples, without the common 1/(2 pi).
static void see_samples(__global const float* samples, int sample_count, float weight_inverse, const float* h,
                        real_v* seen) {
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) seen[s] = (real_v)(0.0f);
  for (int i = 0; i < sample_count; ++i, samples += SAMPLE_STRIDE) {
    const real_v t =
        MAX_V(fma(LOAD_V(samples), (real_v)(h[0]),
                  fma(LOAD_V(samples + MULTUM_GROUP), (real_v)(h[1]), LOAD_V(samples + 2 * MULTUM_GROUP) * h[2])),
              (real_v)(0.0f));
    const real_v t2 = t * t, t4 = t2 * t2, t8 = t4 * t4;
    real_v power = t8 * t8 * t4;  // exponent 20; each further exponent is 5 times as large
#if MULTUM_WEIGHTED
    const real_v weight = LOAD_V(samples + 3 * MULTUM_GROUP) * weight_inverse;
#else
    const real_v weight = (real_v)(weight_inverse);
#endif
    for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
      seen[s] = fma(weight, power, seen[s]);
      const real_v squared = power * power;
      power = squared * squared * power;
    }
  }
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) seen[s] *= brdf_exponents[s] + 1.0f;
}

// Computes the same brightness from the lobes.
static void see_lobes(const RefinedLobe* lobes, const float* h, real_v* seen) {
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
    seen[s] = (real_v)(0.0f);
    const float q = 1.0f / (brdf_exponents[s] + 2.0f), c = 1.0f - q;
    ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
      const RefinedLobe* lobe = lobes + j;
      const Blurred b = blurred((1.0f - lobe->spread) * c, fma(lobe->spread, (real_v)(c), (real_v)(q)));
      const real_v gap =
          MAX_V(gap_of(lobe->x, lobe->y, lobe->z, (real_v)(h[0]), (real_v)(h[1]), (real_v)(h[2])), (real_v)(0.0f));
      seen[s] = fma(lobe->amplitude * b.peak, exp2_v(b.kappa * gap * -MULTUM_LOG2E), seen[s]);
    }
  }
}

// Returns whether the error of `best` is at most `slack` times the error of `start`. The error is the sum of the
// relative L1 errors of all highlights.
static int_v looks_as_good(const RefinedLobe* best, const RefinedLobe* start, float slack,
                           __global const float* samples, int sample_count, float weight_inverse) {
  real_v whole[MULTUM_REFINE_BRDFS], gain[MULTUM_REFINE_BRDFS], total = (real_v)(0.0f);
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) whole[s] = gain[s] = (real_v)(0.0f);
  ROLLED for (int look = 0; look < MULTUM_REFINE_LOOKS; ++look) {
    const float x = look_xy[look][0], y = look_xy[look][1], h[3] = {x, y, sqrt(fma(-x, x, fma(-y, y, 1.0f)))};
    real_v seen[MULTUM_REFINE_BRDFS], by_best[MULTUM_REFINE_BRDFS], by_start[MULTUM_REFINE_BRDFS];
    see_samples(samples, sample_count, weight_inverse, h, seen);
    see_lobes(best, h, by_best);
    see_lobes(start, h, by_start);
    for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) {
      whole[s] += seen[s];
      gain[s] += fma((real_v)(slack), fabs(by_start[s] - seen[s]), -fabs(by_best[s] - seen[s]));
    }
  }
  for (int s = 0; s < MULTUM_REFINE_BRDFS; ++s) total += gain[s] / MAX_V(whole[s], (real_v)(MULTUM_REFINE_SEEN_MIN));
  return total > 0.0f;
}

// Finds the adjacent texel of each lane on one side (left, right, above or below). `weight` is 0 if there is none.
static void find_beside(__global const int* texels, const MultumMovmfFit* fit, int side, int* beside, float* weight) {
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const int texel = max(texels[lane], 0), dx = side == 0 ? -1 : side == 1, dy = side == 2 ? -1 : side == 3;
    const int x = neighbour(texel_column(texel, fit) + dx, fit->width, fit->periodic_x);
    const int y = neighbour(texel_row(texel, fit) + dy, fit->height, fit->periodic_y);
    const int row = y < 0 ? 0 : row_in_window(y, fit->first_row, fit->height);
    const bool is_there = x >= 0 && y >= 0 && row < fit->window_rows;
    beside[lane] = is_there ? row * fit->width + x : texel;
    weight[lane] = is_there ? MULTUM_REFINE_MIDWAY_WEIGHT : 0.0f;
  }
}

// Copies the lobes of those lanes that are set in `better` to `best`.
static void keep_better(const RefinedLobe* lobes, int_v better, RefinedLobe* best) {
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) {
    best[j].amplitude = better ? lobes[j].amplitude : best[j].amplitude;
    best[j].x = better ? lobes[j].x : best[j].x;
    best[j].y = better ? lobes[j].y : best[j].y;
    best[j].z = better ? lobes[j].z : best[j].z;
    best[j].spread = better ? lobes[j].spread : best[j].spread;
    best[j].widening = best[j].spread;
    set_tangents(best + j);
  }
}

__kernel void movmf_refine(__global const float* restrict samples, __global const int* restrict sample_counts,
                           __global const int* restrict texel_list, __global const MultumVmfLobe* restrict level,
                           __global MultumVmfLobe* restrict refined, MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (slot >= fit.slot_count) return;
  const int group = slot / MULTUM_GROUP, sample_count = sample_counts[group];
  const size_t level_size = level_window_size(&fit);
  __global const float* first = samples + (size_t)group * fit.sample_capacity * SAMPLE_STRIDE + slot % MULTUM_GROUP;
  RefinedLobe start[MULTUM_LOBES], beside[MULTUM_LOBES], lobes[MULTUM_LOBES], best[MULTUM_LOBES];
  real_v mean[3], matrix[PARAMETERS * (PARAMETERS + 1) / 2], gradient[PARAMETERS], change[PARAMETERS];
  real_v least = (real_v)(MULTUM_REFINE_ENERGY_MAX);
  int texels[MULTUM_VECTOR_WIDTH];
  float weights[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) texels[lane] = texel_list[slot + lane];
  load_lobes(level, texels, level_size, start);
  ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) lobes[j] = best[j] = start[j];
  ROLLED for (int p = 0; p < PARAMETERS; ++p) change[p] = (real_v)(0.0f);
  mean_of_samples(first, sample_count, fit.total_weight_inverse, mean);
  for (int step = 0;; ++step) {
    real_v energy = (real_v)(0.0f);
    ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) energy +=
        subtract_samples(lobes + j, first, sample_count, fit.total_weight_inverse, gradient + 4 * j);
    energy += add_pairs(lobes, matrix, gradient);
    ROLLED for (int side = 0; side < 4; ++side) {
      find_beside(texel_list + slot, &fit, side, texels, weights);
      load_lobes(level, texels, level_size, beside);
      energy += add_midway(lobes, start, beside, LOAD_V(weights), matrix, gradient);
    }
    energy += add_moments(lobes, mean, matrix, gradient);
    const int_v better = energy < least + MULTUM_REFINE_ENERGY_ROUNDING;
    keep_better(lobes, better, best);
    least = MIN_V(energy, least);
    if (step == MULTUM_REFINE_STEPS) break;
    solve(matrix, gradient);
    ROLLED for (int p = 0; p < PARAMETERS; ++p) change[p] = better ? gradient[p] : change[p] * MULTUM_REFINE_STEP_CUT;
    ROLLED for (int j = 0; j < MULTUM_LOBES; ++j) lobes[j] = best[j];
    take_step(lobes, change);
  }
  const float slack = fit.width * fit.height > 1 ? MULTUM_REFINE_LOOK_SLACK : 1.0f;
  const int_v taken = looks_as_good(best, start, slack, first, sample_count, fit.total_weight_inverse);
  keep_better(start, !taken, best);
  store_lobes(best, refined, texel_list + slot, level_size);
}
