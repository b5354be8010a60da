// SPDX-License-Identifier: Apache-2.0
// Fits one GGX lobe to all normals that a texel covers, by maximum likelihood. The data are the slopes of microfacets.
// About each of these normals, the facets have the GGX distribution of the base roughness.
//
// The slopes x of GGX facets, seen along the normal, have the density 1 / (pi alpha^2 (1 + |x|^2 / alpha^2)^2) (Walter
// et al. 2007, eq. 33, over the projected facet). This density is a bivariate Student t distribution with two degrees
// of freedom and scale matrix S = alpha^2 / 2. The likelihood is maximised as for every t distribution (Lange, Little
// and Taylor 1989, section 3; here nu = 2 and d = 2):
//
//     w = 4 / (2 + (x - m)' S^-1 (x - m))      m = sum(w x) / sum(w)      S = sum(w (x - m) (x - m)') / sum(w)
//
// Dividing by the sum of the weights instead of by their number halves the number of steps; at convergence, the sum
// equals the number (Kent, Tyler and Vardi 1994; as PX-EM: Liu, Rubin and Wu 1998, section 4.1). A facet with a large
// slope has little weight. In a covariance it would dominate, but GGX has no finite covariance. The fit begins with the
// closed form: m = 0 in the frame of the mean normal, and alpha_i^2 = alpha_0^2 + 1.75 lambda_i, where lambda_i are the
// eigenvalues of E[n n'] in the tangent plane. A Gaussian would have the factor 2; on real maps, 1.75 has the least
// error.

#include "device/numerics.clh"
#include "shared/mip_box.h"
#include "shared/one_lobe.h"

#define SPREAD_FACTOR 1.75f
// The least cosine between a facet and the mean normal. It limits slopes to 20. The limit has little effect, because `w
// x x'` hardly depends on the size of a large slope x.
#define FACET_COSINE_MIN 0.05f
#define SCALE_MIN 1e-8f  // least diagonal of S: sqrt(2 S) is 1.4e-4

// A frame about the unit normal n. The frame's x axis is the map's x axis, turned into the tangent plane by
// Gram-Schmidt, as in renderers. The axes are x = (y^2 + z^2, -x y, -x z) / l and y = (0, z, -y) / l, with l^2 = y^2 +
// z^2.
typedef struct LobeFrame {
  real_v xx, xy, xz;  // the frame's x axis
  real_v yy, yz;      // the y axis; its x component is 0
} LobeFrame;

static inline LobeFrame frame_about(real_v x, real_v y, real_v z) {
  const real_v side = MAX_V(fma(y, y, z * z), (real_v)(1e-12f));
  const real_v inverse = 1.0f / sqrt(side);
  LobeFrame frame;
  frame.xx = side * inverse;
  frame.xy = -x * y * inverse;
  frame.xz = -x * z * inverse;
  frame.yy = z * inverse;
  frame.yz = -y * inverse;
  return frame;
}

// Normalizes vectors. A vector without a finite direction becomes (0, 0, 1).
static inline void make_usable(real_v* x, real_v* y, real_v* z) {
  const real_v square = fma(*x, *x, fma(*y, *y, *z * *z));
  const int_v is_usable = (square > 1e-12f) & (square < 1e12f);
  const real_v inverse = 1.0f / sqrt(is_usable ? square : (real_v)(1.0f));
  *x = is_usable ? *x * inverse : (real_v)(0.0f);
  *y = is_usable ? *y * inverse : (real_v)(0.0f);
  *z = is_usable ? *z * inverse : (real_v)(1.0f);
}

#if MULTUM_VECTOR_WIDTH == 1
// One work-item handles one texel of the band. The global size is row_count * map_width.
//   normal_x, normal_y, normal_z [row][map_width]
//   nodes [plane][row][row_length]   written: the texels of MULTUM_ONE_LOBE_PLANES planes
// The kernel is memory bound.
__kernel void one_lobe_finest(__global const float* normal_x, __global const float* normal_y,
                              __global const float* normal_z, __global float* nodes, MultumBoxBand band) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out = nodes + (size_t)(item / band.map_width) * band.row_length + item % band.map_width;
  float x = normal_x[item], y = normal_y[item], z = normal_z[item];
  make_usable(&x, &y, &z);
  out[MULTUM_ONE_LOBE_NORMAL * plane_size] = x;
  out[(MULTUM_ONE_LOBE_NORMAL + 1) * plane_size] = y;
  out[(MULTUM_ONE_LOBE_NORMAL + 2) * plane_size] = z;
  out[MULTUM_ONE_LOBE_XX * plane_size] = x * x;
  out[MULTUM_ONE_LOBE_YY * plane_size] = y * y;
  out[MULTUM_ONE_LOBE_XY * plane_size] = x * y;
  out[MULTUM_ONE_LOBE_XZ * plane_size] = x * z;
  out[MULTUM_ONE_LOBE_YZ * plane_size] = y * z;
}
#endif

// Loads the mean normals of texels as unit vectors. A mean of length 0 becomes (0, 0, 1).
static inline void mean_normals(__global const float* averages, int stride, real_v* x, real_v* y, real_v* z) {
  *x = LOAD_V(averages);
  *y = LOAD_V(averages + stride);
  *z = LOAD_V(averages + 2 * stride);
  const real_v length = length_of(*x, *y, *z);
  const int_v usable = length > 1e-6f;
  const real_v inverse = 1.0f / MAX_V(length, (real_v)(1e-6f));
  *x = usable ? *x * inverse : (real_v)(0.0f);
  *y = usable ? *y * inverse : (real_v)(0.0f);
  *z = usable ? *z * inverse : (real_v)(1.0f);
}

// Returns the index of the first slope of the vector of texels that starts at `texel`, a multiple of
// MULTUM_VECTOR_WIDTH.
static inline size_t slopes_of(int texel, MultumOneLobePiece piece) {
  const size_t block_size = (size_t)(2 * piece.grid * piece.grid) * MULTUM_ONE_LOBE_BLOCK;
  return texel / MULTUM_ONE_LOBE_BLOCK * block_size + texel % MULTUM_ONE_LOBE_BLOCK;
}

// The finest texel of one sample per lane, in the order of the memory.
typedef struct SampledTexels {
  float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], base[MULTUM_VECTOR_WIDTH];
} SampledTexels;

// One work-item handles a row of samples of MULTUM_VECTOR_WIDTH texels, one texel per lane. The global size is
// grid * stride / MULTUM_VECTOR_WIDTH. Lanes after the last texel repeat the last texel.
//   normal_x, normal_y, normal_z [slot][map_width]   rows of the finest level
//   base       [slot][map_width]         alpha^2 of the same texels, if piece.has_base_map
//   row_slots  [row_count][grid]         the slot of each row of samples
//   columns    [width][grid]             the column of each column of samples
//   facets     [grid * grid]             slopes of facets with alpha = 1
//   averages   [plane][stride]           MULTUM_ONE_LOBE_AVERAGES planes; only the normals are used
//   slopes     [texel / block][sample][2][block]   written: of half vectors, in the frame of the mean normal
// Bound by gathered reads, roots and divisions. Samples in the same finest texel share the texel's frame.
__kernel void one_lobe_samples(__global const float* normal_x, __global const float* normal_y,
                               __global const float* normal_z, __global const float* base,
                               __global const int* row_slots, __global const int* columns,
                               __global const float2* facets, __global const float* averages, __global float* slopes,
                               MultumOneLobePiece piece) {
  const int group_count = piece.stride / MULTUM_VECTOR_WIDTH, grid = piece.grid;
  const int item = (int)get_global_id(0);
  if (item >= group_count * grid) return;
  const int sample_row = item / group_count, first = item % group_count * MULTUM_VECTOR_WIDTH;
  int row_start[MULTUM_VECTOR_WIDTH], first_column[MULTUM_VECTOR_WIDTH], before[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const int texel = min(first + lane, piece.row_count * piece.width - 1), row = texel / piece.width;
    row_start[lane] = row_slots[row * grid + sample_row] * piece.map_width;
    first_column[lane] = (texel - row * piece.width) * grid;
    before[lane] = -1;
  }
  real_v mx, my, mz;
  mean_normals(averages + first, piece.stride, &mx, &my, &mz);
  const LobeFrame frame = frame_about(mx, my, mz);
  __global float* out = slopes + slopes_of(first, piece) + 2 * sample_row * grid * MULTUM_ONE_LOBE_BLOCK;
  SampledTexels texels;
  real_v nx = (real_v)(0.0f), ny = nx, nz = (real_v)(1.0f), alpha = nx;
  LobeFrame about = frame_about(nx, ny, nz);
  for (int i = 0; i < grid; ++i, out += 2 * MULTUM_ONE_LOBE_BLOCK) {
    int is_new = 0;
    for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
      const int at = row_start[lane] + columns[first_column[lane] + i];
      is_new |= at ^ before[lane];
      before[lane] = at;
    }
    if (is_new != 0) {
      for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
        const int at = before[lane];
        texels.x[lane] = normal_x[at];
        texels.y[lane] = normal_y[at];
        texels.z[lane] = normal_z[at];
        texels.base[lane] = piece.has_base_map ? base[at] : piece.base_squared;
      }
      nx = LOAD_V(texels.x);
      ny = LOAD_V(texels.y);
      nz = LOAD_V(texels.z);
      make_usable(&nx, &ny, &nz);
      alpha = sqrt(LOAD_V(texels.base));
      about = frame_about(nx, ny, nz);
    }
    const real_v fx = alpha * facets[sample_row * grid + i].x, fy = alpha * facets[sample_row * grid + i].y;
    const real_v hx = fma(fx, about.xx, nx), hy = fma(fx, about.xy, fma(fy, about.yy, ny));
    const real_v hz = fma(fx, about.xz, fma(fy, about.yz, nz));
    const real_v least = FACET_COSINE_MIN * length_of(hx, hy, hz);
    const real_v inverse = 1.0f / MAX_V(fma(hx, mx, fma(hy, my, hz * mz)), least);
    STORE_V(fma(hx, frame.xx, fma(hy, frame.xy, hz * frame.xz)) * inverse, out);
    STORE_V(fma(hy, frame.yy, hz * frame.yz) * inverse, out + MULTUM_ONE_LOBE_BLOCK);
  }
}

// The scale matrix S, which is symmetric and positive.
typedef struct LobeScale {
  real_v xx, xy, yy;
} LobeScale;

// Returns S for alpha_i^2 = alpha_0^2 + 1.75 lambda_i, the closed form.
static inline LobeScale closed_form(__global const float* averages, int stride, LobeFrame f) {
  const real_v xx = LOAD_V(averages + MULTUM_ONE_LOBE_XX * stride), yy = LOAD_V(averages + MULTUM_ONE_LOBE_YY * stride);
  const real_v xy = LOAD_V(averages + MULTUM_ONE_LOBE_XY * stride), xz = LOAD_V(averages + MULTUM_ONE_LOBE_XZ * stride);
  const real_v yz = LOAD_V(averages + MULTUM_ONE_LOBE_YZ * stride), zz = MAX_V(1.0f - xx - yy, (real_v)(0.0f));
  // The products of E[n n'] and the axes of the frame, and the scalar products of the results with the axes.
  const real_v ax = fma(xx, f.xx, fma(xy, f.xy, xz * f.xz)), ay = fma(xy, f.xx, fma(yy, f.xy, yz * f.xz));
  const real_v az = fma(xz, f.xx, fma(yz, f.xy, zz * f.xz));
  const real_v by = fma(yy, f.yy, yz * f.yz), bz = fma(yz, f.yy, zz * f.yz);
  const real_v half_base = 0.5f * LOAD_V(averages + MULTUM_ONE_LOBE_BASE * stride);
  LobeScale s;
  s.xx = fma((real_v)(0.5f * SPREAD_FACTOR), MAX_V(fma(ax, f.xx, fma(ay, f.xy, az * f.xz)), (real_v)(0.0f)), half_base);
  s.yy = fma((real_v)(0.5f * SPREAD_FACTOR), MAX_V(fma(by, f.yy, bz * f.yz), (real_v)(0.0f)), half_base);
  s.xy = 0.5f * SPREAD_FACTOR * fma(ay, f.yy, az * f.yz);
  return s;
}

// Makes S invertible by limiting its diagonal from below and keeping its correlation below 1. If S must be isotropic,
// it is replaced by its mean over all directions.
static inline LobeScale bounded(LobeScale s, int is_anisotropic) {
  s.xx = MAX_V(s.xx, (real_v)(SCALE_MIN));
  s.yy = MAX_V(s.yy, (real_v)(SCALE_MIN));
  if (!is_anisotropic) {
    s.xx = s.yy = 0.5f * (s.xx + s.yy);
    s.xy = (real_v)(0.0f);
    return s;
  }
  // Allows ratios of up to about 500 between the variances, and of up to about 22 between the alphas.
  const real_v most = 0.996f * sqrt(s.xx * s.yy);
  s.xy = MIN_V(MAX_V(s.xy, -most), most);
  return s;
}

// Does one step of EM over the texels' samples.
static inline LobeScale em_step(__global const float* slopes, MultumOneLobePiece piece, LobeScale s, real_v* mx,
                                real_v* my) {
  const real_v inverse = 1.0f / fma(s.xx, s.yy, -s.xy * s.xy);
  const real_v pxx = s.yy * inverse, pxy = -2.0f * s.xy * inverse, pyy = s.xx * inverse;
  real_v sum = (real_v)(0.0f), sum_x = sum, sum_y = sum, sum_xx = sum, sum_xy = sum, sum_yy = sum;
  const int sample_count = piece.grid * piece.grid;
  for (int k = 0; k < sample_count; ++k) {
    const real_v x = LOAD_V(slopes + 2 * k * MULTUM_ONE_LOBE_BLOCK) - *mx;
    const real_v y = LOAD_V(slopes + (2 * k + 1) * MULTUM_ONE_LOBE_BLOCK) - *my;
    const real_v w = 4.0f / (2.0f + fma(pxx * x, x, fma(pxy * x, y, pyy * y * y)));
    const real_v wx = w * x, wy = w * y;
    sum += w;
    sum_x += wx;
    sum_y += wy;
    sum_xx = fma(wx, x, sum_xx);
    sum_xy = fma(wx, y, sum_xy);
    sum_yy = fma(wy, y, sum_yy);
  }
  // The moments about the new mean are computed from sums about the old mean.
  const real_v share = 1.0f / sum, dx = sum_x * share, dy = sum_y * share;
  s.xx = fma(-sum_x, dx, sum_xx) * share;
  s.xy = fma(-sum_x, dy, sum_xy) * share;
  s.yy = fma(-sum_y, dy, sum_yy) * share;
  *mx += dx;
  *my += dy;
  return bounded(s, piece.is_anisotropic);
}

// One work-item handles MULTUM_VECTOR_WIDTH texels, one per lane. The global size is stride / MULTUM_VECTOR_WIDTH.
//   averages [plane][stride]       MULTUM_ONE_LOBE_AVERAGES planes
//   slopes   [texel / block][sample][2][block]   from one_lobe_samples; not read if there are no samples
//   fitted   [plane][stride]       written: MULTUM_ONE_LOBE_FITTED planes
// The kernel is compute bound: iteration_count * grid^2 weights per texel.
__kernel void one_lobe_fit(__global const float* averages, __global const float* slopes, __global float* fitted,
                           MultumOneLobePiece piece) {
  const int first = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH, stride = piece.stride;
  if (first >= stride) return;
  averages += first;
  slopes += slopes_of(first, piece);
  fitted += first;
  real_v nx, ny, nz;
  mean_normals(averages, stride, &nx, &ny, &nz);
  const LobeFrame frame = frame_about(nx, ny, nz);
  LobeScale s = bounded(closed_form(averages, stride, frame), piece.is_anisotropic);
  real_v mx = (real_v)(0.0f), my = mx;
  const int steps = piece.grid > 0 ? piece.iteration_count : 0;
  for (int i = 0; i < steps; ++i) s = em_step(slopes, piece, s, &mx, &my);

  // The mean normal, moved by the fitted mean slope.
  real_v x = fma(mx, frame.xx, nx), y = fma(mx, frame.xy, fma(my, frame.yy, ny));
  real_v z = fma(mx, frame.xz, fma(my, frame.yz, nz));
  const real_v inverse = 1.0f / length_of(x, y, z);
  x *= inverse;
  y *= inverse;
  z *= inverse;
  STORE_V(x, fitted);
  STORE_V(y, fitted + stride);
  STORE_V(z, fitted + 2 * stride);

  // S is middle + [half, xy; xy, -half], whose eigenvalues are middle +- radius. The axis of the larger eigenvalue is
  // at half the angle of (half, xy). Of two formulas for this axis, the one without a subtraction is used.
  const real_v middle = 0.5f * (s.xx + s.yy), half_difference = 0.5f * (s.xx - s.yy);
  const real_v radius = sqrt(fma(half_difference, half_difference, s.xy * s.xy));
  const int_v along_x = half_difference >= 0.0f;
  const real_v long_side = radius + fabs(half_difference);
  real_v ax = along_x ? long_side : s.xy, ay = along_x ? s.xy : long_side;
  const real_v axis_length = sqrt(fma(ax, ax, ay * ay));
  const int_v has_axis = axis_length > 1e-12f;
  ax = has_axis ? ax / MAX_V(axis_length, (real_v)(1e-12f)) : (real_v)(1.0f);
  ay = has_axis ? ay / MAX_V(axis_length, (real_v)(1e-12f)) : (real_v)(0.0f);
  const real_v least = (real_v)(piece.alpha_min);
  STORE_V(MIN_V(MAX_V(sqrt(2.0f * (middle + radius)), least), (real_v)(1.0f)),
          fitted + MULTUM_ONE_LOBE_ALPHA_WIDE * stride);
  STORE_V(MIN_V(MAX_V(sqrt(2.0f * MAX_V(middle - radius, (real_v)(0.0f))), least), (real_v)(1.0f)),
          fitted + MULTUM_ONE_LOBE_ALPHA_NARROW * stride);
  // The axis as a direction, in the frame of the moved normal.
  const LobeFrame moved = frame_about(x, y, z);
  const real_v dx = ax * frame.xx, dy = fma(ax, frame.xy, ay * frame.yy), dz = fma(ax, frame.xz, ay * frame.yz);
  const real_v tx = fma(dx, moved.xx, fma(dy, moved.xy, dz * moved.xz)), ty = fma(dy, moved.yy, dz * moved.yz);
  const real_v scale = 1.0f / MAX_V(sqrt(fma(tx, tx, ty * ty)), (real_v)(1e-12f));
  STORE_V(tx * scale, fitted + MULTUM_ONE_LOBE_AXIS * stride);
  STORE_V(ty * scale, fitted + (MULTUM_ONE_LOBE_AXIS + 1) * stride);
}
