// SPDX-License-Identifier: Apache-2.0
// Pyramidal regularisation (Hakura et al. 2000, section 3.2, eq. 6): Gamma(x) = sum of (x - B x')^2 over the texels of
// all levels but the coarsest, x' = the next coarser level, B = bilinear interpolation. Half its gradient is
// R^T R x with R x = x - B x'. Every texel is defined then, and holes fill smoothly.

#include "shared/mip_pyramid.h"

int level_of_texel(__global const MultumMipLevel* levels, int level_count, int texel) {
  int l = 0;
  while (l + 1 < level_count && texel >= levels[l + 1].offset) ++l;
  return l;
}

// One work-item = one texel; global size texel_count.
//   coarse_taps [..]       by MultumMipLevel
//   x           [texels]   three colours and 0
//   residual    [texels]   written: R x; 0 in the coarsest level
// Memory bound.
__kernel void pyramid_residual(__global const MultumMipLevel* levels, __global const MultumCoarseTap* coarse_taps,
                               __global const float4* x, __global float4* residual, int level_count, int texel_count) {
  const int texel = (int)get_global_id(0);
  if (texel >= texel_count) return;
  const int l = level_of_texel(levels, level_count, texel);
  if (l + 1 == level_count) {
    residual[texel] = (float4)(0.0f);
    return;
  }
  const MultumMipLevel fine = levels[l];
  const int i = texel - fine.offset, y = i / fine.width;
  const MultumCoarseTap column = coarse_taps[fine.coarse_columns + i - y * fine.width];
  const MultumCoarseTap row = coarse_taps[fine.coarse_rows + y];
  __global const float4* upper = x + levels[l + 1].offset + row.first * levels[l + 1].width;
  __global const float4* lower = x + levels[l + 1].offset + row.second * levels[l + 1].width;
  residual[texel] = x[texel] - mix(mix(upper[column.first], upper[column.second], column.fraction),
                                   mix(lower[column.first], lower[column.second], column.fraction), row.fraction);
}

// Adds weight * R^T residual to `sum`. One work-item = one texel; global size texel_count.
//   fine_begin [..]       by MultumMipLevel, into fine_taps
//   residual   [texels]   R x
//   sum        [texels]   read and written
// Memory bound.
__kernel void pyramid_gradient(__global const MultumMipLevel* levels, __global const int* fine_begin,
                               __global const MultumFineTap* fine_taps, __global const float4* residual,
                               __global float4* sum, int level_count, int texel_count, float weight) {
  const int texel = (int)get_global_id(0);
  if (texel >= texel_count) return;
  const int l = level_of_texel(levels, level_count, texel);
  float4 gathered = residual[texel];
  if (l > 0) {
    const MultumMipLevel fine = levels[l - 1], coarse = levels[l];
    const int i = texel - coarse.offset, y = i / coarse.width;
    const int column = coarse.fine_columns + i - y * coarse.width, row = coarse.fine_rows + y;
    for (int k = fine_begin[row]; k < fine_begin[row + 1]; ++k) {
      __global const float4* from = residual + fine.offset + fine_taps[k].index * fine.width;
      float4 line = (float4)(0.0f);
      for (int m = fine_begin[column]; m < fine_begin[column + 1]; ++m)
        line += fine_taps[m].weight * from[fine_taps[m].index];
      gathered -= fine_taps[k].weight * line;
    }
  }
  sum[texel] += weight * gathered;
}
