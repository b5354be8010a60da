// SPDX-License-Identifier: Apache-2.0
// Projects the normal distribution of a finest texel to spherical harmonics (Han et al. 2007, section 5). The
// coefficients are the basis functions at its normal, g_lm = Y_lm(n). mip_box.cl averages the coefficients, which is
// exact because they are linear in the distribution. If normals include a BRDF's width, a normal n is shortened to c n,
// and represents facets about n. Its coefficients are then g_lm = a_l Y_lm(n), where a_l are the zonal coefficients of
// the vMF with mean cosine c.

#include "device/vmf_zonal.clh"
#include "shared/mip_box.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "sh_project has only a scalar variant"
#endif

// One work-item handles one texel of the band. The global size is row_count * map_width.
//   normal_x, normal_y, normal_z [row][map_width]
//   steps [(order + 1) (order + 2) / 2]            the recurrence's constants
//   nodes [plane][row][row_length]                 written: the coefficients from l = 1
//   shortened                                      if not 0, the lengths of normals hold a BRDF's width
// The kernel is memory bound.
__kernel void sh_project(__global const float* normal_x, __global const float* normal_y, __global const float* normal_z,
                         __global const float2* steps, __global float* nodes, MultumBoxBand band, int shortened) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out = nodes + (size_t)(item / band.map_width) * band.row_length + item % band.map_width;
  const float3 n = sh_direction(normal_x[item], normal_y[item], normal_z[item]);
  float zonal[MULTUM_SH_ORDER + 1];
  vmf_zonal(shortened ? length_of(normal_x[item], normal_y[item], normal_z[item]) : 1.0f, zonal);
  float c = 1.0f, s = 0.0f;  // (x + iy)^m
  int step = 0;
  for (int m = 0; m <= MULTUM_SH_ORDER; ++m) {
    float before = 0.0f, p = steps[step++].x;
    for (int l = m; l <= MULTUM_SH_ORDER; ++l) {
      if (l > m) {
        const float next = fma(steps[step].x * n.z, p, -steps[step].y * before);
        before = p;
        p = next;
        ++step;
      }
      const int centre = l * l + l - 1;
      if (l > 0) out[(centre + m) * plane_size] = zonal[l] * (p * c);
      if (m > 0) out[(centre - m) * plane_size] = zonal[l] * (p * s);
    }
    const float rotated = fma(c, n.x, -s * n.y);
    s = fma(c, n.y, s * n.x);
    c = rotated;
  }
}
