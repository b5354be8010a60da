// SPDX-License-Identifier: Apache-2.0
// What mixes linearly of a normal map: slope moments (LEAN: Olano and Baker 2010, section 3) and the normal (Toksvig
// 2005). Nothing is fitted: kernels/mip_box.cl averages these planes.

#include "device/numerics.clh"
#include "shared/mip_box.h"
#include "shared/moments.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "moments has only a scalar variant"
#endif

// One work-item = one texel of the band; global size row_count * map_width.
//   normal_x, normal_y, normal_z, red, green, blue [row][map_width]  colours: anything where there are none
//   nodes [plane][row][row_length]                                   written: the texels
// Memory bound.
__kernel void moment_finest(__global const float* normal_x, __global const float* normal_y,
                            __global const float* normal_z, __global const float* red, __global const float* green,
                            __global const float* blue, __global float* nodes, MultumBoxBand band, float slope_z_min) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out = nodes + (size_t)(item / band.map_width) * band.row_length + item % band.map_width;
  const float x = normal_x[item], y = normal_y[item], z = normal_z[item];
  // Division last: -x/z is what maketx has, to the last bit.
  const float limited = z > slope_z_min ? z : slope_z_min;
  const float s = -x / limited, t = -y / limited;
  out[MULTUM_MOMENT_S * plane_size] = s;
  out[MULTUM_MOMENT_T * plane_size] = t;
  out[MULTUM_MOMENT_SS * plane_size] = s * s;
  out[MULTUM_MOMENT_TT * plane_size] = t * t;
  out[MULTUM_MOMENT_ST * plane_size] = s * t;
  out[MULTUM_MOMENT_NORMAL * plane_size] = x;
  out[(MULTUM_MOMENT_NORMAL + 1) * plane_size] = y;
  out[(MULTUM_MOMENT_NORMAL + 2) * plane_size] = z;
  if (band.plane_count <= MULTUM_MOMENT_COLOUR) return;
  out[MULTUM_MOMENT_COLOUR * plane_size] = red[item];
  out[(MULTUM_MOMENT_COLOUR + 1) * plane_size] = green[item];
  out[(MULTUM_MOMENT_COLOUR + 2) * plane_size] = blue[item];
}
