// SPDX-License-Identifier: Apache-2.0
// Does the vector operations of the preconditioned conjugate gradient method on three colours at once. Each colour has
// its own scalars. Each work-item sums one fixed range, and the host adds these parts in double precision, so the
// result does not depend on the number of threads.
//
// All kernels are memory bound. An iteration therefore passes over its vectors only three times: to compute alpha, to
// compute beta, and to make the update that needs both. The preconditioned residual is computed twice instead of being
// stored.

// The range of texels that a work-item sums over.
int part_begin(int texel_count, int part, int part_count) { return (int)(((long)texel_count * part) / part_count); }

// Computes parts[part], which is the sum of p q over the part's range. If is_bounded, first sets q = is_free (q +
// diagonal p). This formula adds the diagonal of range regularisation, and sets q to 0 for texels that are fixed at a
// bound. One work-item handles one part. The global size is part_count.
__kernel void curvature_product(__global const float4* p, __global float4* q, __global const float4* diagonal,
                                __global const float4* is_free, __global float4* parts, int is_bounded, int texel_count,
                                int part_count) {
  const int part = (int)get_global_id(0);
  if (part >= part_count) return;
  const int end = part_begin(texel_count, part + 1, part_count);
  float4 sum = (float4)(0.0f);
  if (is_bounded) {
    for (int i = part_begin(texel_count, part, part_count); i < end; ++i) {
      const float4 product = is_free[i] * (q[i] + diagonal[i] * p[i]);
      q[i] = product;
      sum += p[i] * product;
    }
  } else {
    for (int i = part_begin(texel_count, part, part_count); i < end; ++i) sum += p[i] * q[i];
  }
  parts[part] = sum;
}

// Computes r -= alpha q. Over the part's range, parts[part] = sum of r inverse_diagonal r, and
// parts[part_count + part] = sum of r r.
// One work-item handles one part. The global size is part_count.
__kernel void advance_residual(__global float4* r, __global const float4* q, __global const float4* inverse_diagonal,
                               __global float4* parts, float4 alpha, int texel_count, int part_count) {
  const int part = (int)get_global_id(0);
  if (part >= part_count) return;
  const int end = part_begin(texel_count, part + 1, part_count);
  float4 product = (float4)(0.0f), norm = (float4)(0.0f);
  for (int i = part_begin(texel_count, part, part_count); i < end; ++i) {
    const float4 residual = r[i] - alpha * q[i];
    const float4 square = residual * residual;
    r[i] = residual;
    product += inverse_diagonal[i] * square;
    norm += square;
  }
  parts[part] = product;
  parts[part_count + part] = norm;
}

// Computes step += alpha p and p = inverse_diagonal r + beta p. One work-item handles one texel. The global size is
// texel_count.
__kernel void advance_direction(__global float4* step, __global float4* p, __global const float4* r,
                                __global const float4* inverse_diagonal, float4 alpha, float4 beta, int texel_count) {
  const int i = (int)get_global_id(0);
  if (i >= texel_count) return;
  const float4 direction = p[i];
  step[i] += alpha * direction;
  p[i] = inverse_diagonal[i] * r[i] + beta * direction;
}
