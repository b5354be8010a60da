// SPDX-License-Identifier: Apache-2.0
// Computes the planes of a normal map that mix linearly. These are slope moments (LEAN: Olano and Baker 2010, section
// 3) and the normal (Toksvig 2005). Nothing is fitted. kernels/mip_box.cl averages these planes.

#include "device/numerics.clh"
#include "shared/mip_box.h"
#include "shared/moments.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "moments has only a scalar variant"
#endif

// One work-item handles one texel of the band. The global size is row_count * map_width.
//   normal_x, normal_y, normal_z [row][map_width]
//   nodes [plane][row][row_length]                 written: the texels of MULTUM_MOMENT_PLANES planes
// If normals are shortened to length c by a BRDF's width (`shortened`), the slopes of its microfacets have the variance
// 1 - c about the normal's slope (host/formats/image/material_maps.h). The kernel is memory bound.
__kernel void moment_finest(__global const float* normal_x, __global const float* normal_y,
                            __global const float* normal_z, __global float* nodes, MultumBoxBand band,
                            float slope_z_min, int shortened) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out = nodes + (size_t)(item / band.map_width) * band.row_length + item % band.map_width;
  const float x = normal_x[item], y = normal_y[item], z = normal_z[item];
  // Computes -x/z by a division, as maketx does, because the results must be equal bit by bit.
  const float length = shortened ? sqrt(fma(x, x, fma(y, y, z * z))) : 1.0f;
  // The slope of a normal of length 0 is 0 instead of 0 / 0.
  const float z_min = slope_z_min * MAX_V(length, 1e-6f), variance = MAX_V(1.0f - length, 0.0f);
  const float limited = z > z_min ? z : z_min;
  const float s = -x / limited, t = -y / limited;
  out[MULTUM_MOMENT_S * plane_size] = s;
  out[MULTUM_MOMENT_T * plane_size] = t;
  out[MULTUM_MOMENT_SS * plane_size] = s * s + variance;
  out[MULTUM_MOMENT_TT * plane_size] = t * t + variance;
  out[MULTUM_MOMENT_ST * plane_size] = s * t;
  out[MULTUM_MOMENT_NORMAL * plane_size] = x;
  out[(MULTUM_MOMENT_NORMAL + 1) * plane_size] = y;
  out[(MULTUM_MOMENT_NORMAL + 2) * plane_size] = z;
}
