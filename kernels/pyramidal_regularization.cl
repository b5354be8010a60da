// SPDX-License-Identifier: Apache-2.0
// Pyramidal regularisation (Hakura et al. 2000, section 3.2, eq. 6): Gamma(x) = sum of (x - B x')^2 over the texels of
// all levels but the coarsest, x' = the next coarser level, B = bilinear interpolation. Half its gradient is
// R^T R x with R x = x - B x'. Every texel is defined then, and holes fill smoothly.

#include "device/mip_pyramid.clh"

// One work-item = one texel; global size pyramid.texel_count.
//   x        [texels]   three colours and 0
//   residual [texels]   written: R x; 0 in the coarsest level
// Memory bound.
__kernel void pyramid_residual(__global const MultumMipLevel* levels, __global const float4* x,
                               __global float4* residual, MultumPyramid pyramid) {
  const int texel = (int)get_global_id(0);
  if (texel >= pyramid.texel_count) return;
  const int l = level_of_texel(levels, pyramid.level_count, texel);
  if (l + 1 == pyramid.level_count) {
    residual[texel] = (float4)(0.0f);
    return;
  }
  const MultumMipLevel fine = levels[l], coarse = levels[l + 1];
  const int i = texel - fine.offset;
  const float at_x = coarse_position(i % fine.width, fine.width, coarse.width, pyramid.periodic_s);
  const float at_y = coarse_position(i / fine.width, fine.height, coarse.height, pyramid.periodic_t);
  const int x0 = (int)floor(at_x), y0 = (int)floor(at_y);
  const float fx = at_x - (float)x0, fy = at_y - (float)y0;
  const int left = pyramid.periodic_s ? wrapped_index(x0, coarse.width) : x0;
  const int right = pyramid.periodic_s ? wrapped_index(x0 + 1, coarse.width) : min(x0 + 1, coarse.width - 1);
  const int top = pyramid.periodic_t ? wrapped_index(y0, coarse.height) : y0;
  const int bottom = pyramid.periodic_t ? wrapped_index(y0 + 1, coarse.height) : min(y0 + 1, coarse.height - 1);
  __global const float4* from = x + coarse.offset;
  const float4 upper = mix(from[top * coarse.width + left], from[top * coarse.width + right], fx);
  const float4 lower = mix(from[bottom * coarse.width + left], from[bottom * coarse.width + right], fx);
  residual[texel] = x[texel] - mix(upper, lower, fy);
}

// Adds weight * R^T residual to `sum`.
// One work-item = one texel; global size pyramid.texel_count.
//   residual [texels]   R x
//   sum      [texels]   read and written
// Memory bound.
__kernel void pyramid_gradient(__global const MultumMipLevel* levels, __global const float4* residual,
                               __global float4* sum, MultumPyramid pyramid, float weight) {
  const int texel = (int)get_global_id(0);
  if (texel >= pyramid.texel_count) return;
  const int l = level_of_texel(levels, pyramid.level_count, texel);
  float4 gathered = residual[texel];
  if (l > 0) {
    const MultumMipLevel fine = levels[l - 1], coarse = levels[l];
    const int i = texel - coarse.offset, cx = i % coarse.width, cy = i / coarse.width;
    const FineRange columns = fine_range(cx, fine.width, coarse.width, pyramid.periodic_s);
    const FineRange rows = fine_range(cy, fine.height, coarse.height, pyramid.periodic_t);
    for (int dy = 0; dy < rows.count; ++dy) {
      const int y = wrapped_index(rows.first + dy, fine.height);
      const float wy = coarse_weight(coarse_position(y, fine.height, coarse.height, pyramid.periodic_t), cy,
                                     coarse.height, pyramid.periodic_t);
      if (wy == 0.0f) continue;
      for (int dx = 0; dx < columns.count; ++dx) {
        const int fx = wrapped_index(columns.first + dx, fine.width);
        const float wx = coarse_weight(coarse_position(fx, fine.width, coarse.width, pyramid.periodic_s), cx,
                                       coarse.width, pyramid.periodic_s);
        gathered -= wx * wy * residual[fine.offset + y * fine.width + fx];
      }
    }
  }
  sum[texel] += weight * gathered;
}
