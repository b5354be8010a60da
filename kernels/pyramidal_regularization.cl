// SPDX-License-Identifier: Apache-2.0
// Computes pyramidal regularisation (Hakura et al. 2000, section 3.2, eq. 6). Gamma(x) is the sum of (x - B x')^2 over
// the texels of all levels except the coarsest, where x' is the next coarser level and B is bilinear interpolation.
// Half the gradient of Gamma is R^T R x with R x = x - B x'. The regularisation gives every texel a value, and fills
// holes smoothly.

#include "shared/mip_pyramid.h"

// One work-item handles one strip of texels. The global size is strip_count.
//   levels, taps, strips   tables
//   x        [texels]      three colours and 0
//   residual [texels]      written: R x; 0 in the coarsest level
// The kernel is memory bound.
__kernel void pyramid_residual(__global const MultumMipLevel* levels, __global const MultumTap* taps,
                               __global const MultumStrip* strips, __global const float4* x, __global float4* residual,
                               int strip_count, int level_count) {
  const int item = (int)get_global_id(0);
  if (item >= strip_count) return;
  const MultumStrip strip = strips[item];
  const MultumMipLevel level = levels[strip.level];
  const int row = level.offset + strip.y * level.width;
  if (strip.level + 1 == level_count) {
    for (int i = strip.x_begin; i < strip.x_end; ++i) residual[row + i] = (float4)(0.0f);
    return;
  }
  const MultumMipLevel coarse = levels[strip.level + 1];
  const MultumTap down = taps[level.taps_y + strip.y];
  __global const float4* upper = x + coarse.offset + down.first * coarse.width;
  __global const float4* lower = x + coarse.offset + down.second * coarse.width;
  for (int i = strip.x_begin; i < strip.x_end; ++i) {
    const MultumTap across = taps[level.taps_x + i];
    const float4 left = mix(upper[across.first], lower[across.first], down.fraction);
    const float4 right = mix(upper[across.second], lower[across.second], down.fraction);
    residual[row + i] = x[row + i] - mix(left, right, across.fraction);
  }
}

// Adds weight * R^T residual to `sum`.
// One work-item handles one strip of texels. The global size is strip_count.
//   levels, gathers, entries, strips   tables
//   residual [texels]   R x
//   sum      [texels]   read and written
// The kernel is memory bound.
__kernel void pyramid_gradient(__global const MultumMipLevel* levels, __global const MultumGather* gathers,
                               __global const MultumGatherEntry* entries, __global const MultumStrip* strips,
                               __global const float4* residual, __global float4* sum, int strip_count, float weight) {
  const int item = (int)get_global_id(0);
  if (item >= strip_count) return;
  const MultumStrip strip = strips[item];
  const MultumMipLevel level = levels[strip.level];
  const int row = level.offset + strip.y * level.width;
  for (int i = strip.x_begin; i < strip.x_end; ++i) {
    const int texel = row + i;
    float4 gathered = residual[texel];
    if (strip.level > 0) {
      const MultumMipLevel fine = levels[strip.level - 1];
      const MultumGather down = gathers[level.gathers_y + strip.y], across = gathers[level.gathers_x + i];
      for (int v = down.begin; v < down.begin + down.count; ++v) {
        __global const float4* from = residual + fine.offset + entries[v].fine * fine.width;
        float4 of_row = (float4)(0.0f);
        for (int u = across.begin; u < across.begin + across.count; ++u)
          of_row += entries[u].weight * from[entries[u].fine];
        gathered -= entries[v].weight * of_row;
      }
    }
    sum[texel] += weight * gathered;
  }
}
