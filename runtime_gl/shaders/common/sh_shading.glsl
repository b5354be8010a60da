// SPDX-License-Identifier: Apache-2.0
// Shades filtered spherical harmonics of the normals under a fragment (Han et al. 2007, section 5), in the format of
// `multum bake --ndf sh`. A texture array holds four coefficients per layer; coefficient (l, m), l >= 1, has the index
// l*l + l + m - 1. Coefficients are linear in the normals, so hardware filters them exactly, for any spread. A renderer
// defines
//
//     MULTUM_SH_ORDER    the order of the file, multum:shOrder
//     MULTUM_SH_STEPS    vec2[](...), the recurrence's constants: for each m from 0 first (p_mm, 0), then (a_lm, b_lm)
//                        of l = m + 1 to the order (host/formats/asset/averages/spherical_harmonics.h, sh_recurrence())
//
// and multiplies the bands by the zonal coefficients of its BRDF, a_l = 2 pi integral f(t) P_l(t) dt. Any BRDF of one
// angle can be used, at run time. The series is cut off above MULTUM_SH_ORDER. This blurs a sharp highlight and
// surrounds it with rings, whose negative parts are clamped. No window is applied to the coefficients: every window
// that was tried has a higher error wherever the order is sufficient (docs/contributing/ALGORITHMS.md, "Spherical
// harmonics", has the figures).
//
// kernels/device/spherical_harmonics.clh has the same formulas; tests/agreement compares both with double precision.

#define MULTUM_SH_COUNT (MULTUM_SH_ORDER * (MULTUM_SH_ORDER + 2))
#define MULTUM_SH_PARTS ((MULTUM_SH_COUNT + 3) / 4)

const float MULTUM_SH_CONSTANT = 0.28209479;  // Y_00
const vec2 multum_sh_steps[(MULTUM_SH_ORDER + 1) * (MULTUM_SH_ORDER + 2) / 2] = MULTUM_SH_STEPS;

float multum_sh_coefficient(vec4 parts[MULTUM_SH_PARTS], int l, int m) {
  int i = l * l + l + m - 1;
  return parts[i >> 2][i & 3];
}

// Computes bands[l] = sum over m of g_lm Y_lm(w) for a unit vector w. `share` multiplies the coefficient of l = 0,
// which is not stored. Every loop has constant bounds, so that compilers can unroll it.
void multum_sh_bands(vec4 parts[MULTUM_SH_PARTS], float share, vec3 w, out float bands[MULTUM_SH_ORDER + 1]) {
  bands[0] = share * MULTUM_SH_CONSTANT * MULTUM_SH_CONSTANT;
  for (int l = 1; l <= MULTUM_SH_ORDER; ++l) bands[l] = 0.0;
  float c = 1.0, s = 0.0;  // (x + iy)^m
  int step = 0;
  for (int m = 0; m <= MULTUM_SH_ORDER; ++m) {
    float before = 0.0, p = 0.0;
    for (int l = 0; l <= MULTUM_SH_ORDER; ++l) {
      if (l < m) continue;
      vec2 k = multum_sh_steps[step++];
      float next = l == m ? k.x : k.x * w.z * p - k.y * before;
      before = p;
      p = next;
      if (l > 0) bands[l] += p * c * multum_sh_coefficient(parts, l, m);
      if (m > 0) bands[l] += p * s * multum_sh_coefficient(parts, l, -m);
    }
    float rotated = c * w.x - s * w.y;
    s = c * w.y + s * w.x;
    c = rotated;
  }
}

// Returns the sum over l and m of c_lm Y_lm(w) for a unit vector w, with coefficient (l, m) at index l (l + 1) + m.
vec3 multum_sh_colour(vec3 coefficients[MULTUM_SH_COUNT + 1], vec3 w) {
  vec3 sum = vec3(0.0);
  float c = 1.0, s = 0.0;  // (x + iy)^m
  int step = 0;
  for (int m = 0; m <= MULTUM_SH_ORDER; ++m) {
    float before = 0.0, p = 0.0;
    for (int l = 0; l <= MULTUM_SH_ORDER; ++l) {
      if (l < m) continue;
      vec2 k = multum_sh_steps[step++];
      float next = l == m ? k.x : k.x * w.z * p - k.y * before;
      before = p;
      p = next;
      sum += p * c * coefficients[l * (l + 1) + m];
      if (m > 0) sum += p * s * coefficients[l * (l + 1) - m];
    }
    float rotated = c * w.x - s * w.y;
    s = c * w.y + s * w.x;
    c = rotated;
  }
  return sum;
}

// Returns E[n], which is computed from the band l = 1.
vec3 multum_sh_mean_normal(vec4 parts[MULTUM_SH_PARTS]) { return parts[0].zxy / 0.48860251; }

// Returns E[n n^T], which is computed from the band l = 2. Order 1 has no such band, so the result is then that of
// uniform directions.
mat3 multum_sh_second_moments(vec4 parts[MULTUM_SH_PARTS]) {
#if MULTUM_SH_ORDER < 2
  return mat3(1.0 / 3.0);
#else
  float xy = parts[0].w / 1.09254843, yz = parts[1].x / 1.09254843, zx = parts[1].z / 1.09254843;
  float zz = (parts[1].y / 0.31539157 + 1.0) / 3.0, difference = parts[1].w / 0.54627422;  // E[x^2] - E[y^2]
  float xx = 0.5 * (1.0 - zz + difference), yy = 0.5 * (1.0 - zz - difference);
  return mat3(xx, xy, zx, xy, yy, yz, zx, yz, zz);
#endif
}

// Returns max(n . l, 0), integrated over the normals: a_l = pi, 2 pi/3, pi/4, 0, -pi/24, 0, ...,
// a_l = a_l-2 (3 - l)/(l + 2).
float multum_sh_lambert(vec4 parts[MULTUM_SH_PARTS], float share, vec3 light) {
  float bands[MULTUM_SH_ORDER + 1];
  multum_sh_bands(parts, share, light, bands);
  float sum = 3.14159265 * (bands[0] + 2.0 / 3.0 * bands[1]);
  float a = 3.14159265;
  for (int l = 2; l <= MULTUM_SH_ORDER; l += 2) {
    a *= float(3 - l) / float(l + 2);
    sum += a * bands[l];
  }
  return max(sum, 0.0);
}

// Returns f(n . h), integrated over the normals, for a BRDF with the given zonal coefficients.
vec3 multum_sh_facets(vec4 parts[MULTUM_SH_PARTS], float share, vec3 h, vec3 zonal[MULTUM_SH_ORDER + 1]) {
  float bands[MULTUM_SH_ORDER + 1];
  multum_sh_bands(parts, share, h, bands);
  vec3 sum = vec3(0.0);
  for (int l = 0; l <= MULTUM_SH_ORDER; ++l) sum += zonal[l] * bands[l];
  return max(sum, vec3(0.0));
}
