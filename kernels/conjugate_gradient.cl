// SPDX-License-Identifier: Apache-2.0
// The vector operations of preconditioned conjugate gradient on three colours at once, each with scalars of its own.
// Sums are formed in parts, one a work-item over a fixed range, and added up by the host in double: the same bytes
// whatever the number of threads.

// The range of texels that a work-item sums over.
int part_begin(int texel_count, int part, int part_count) { return (int)(((long)texel_count * part) / part_count); }

// parts[part] = sum of a * b over the part's range. One work-item = one part; global size part_count.
__kernel void dot_product(__global const float4* a, __global const float4* b, __global float4* parts, int texel_count,
                          int part_count) {
  const int part = (int)get_global_id(0);
  if (part >= part_count) return;
  const int end = part_begin(texel_count, part + 1, part_count);
  float4 sum = (float4)(0.0f);
  for (int i = part_begin(texel_count, part, part_count); i < end; ++i) sum += a[i] * b[i];
  parts[part] = sum;
}

// step += alpha p, r -= alpha q, z = inverse_diagonal r; parts = sums of r z, norms = sums of r r.
// One work-item = one part; global size part_count.
__kernel void advance_solution(__global float4* step, __global float4* r, __global float4* z, __global const float4* p,
                               __global const float4* q, __global const float4* inverse_diagonal,
                               __global float4* parts, __global float4* norms, float4 alpha, int texel_count,
                               int part_count) {
  const int part = (int)get_global_id(0);
  if (part >= part_count) return;
  const int end = part_begin(texel_count, part + 1, part_count);
  float4 product = (float4)(0.0f), norm = (float4)(0.0f);
  for (int i = part_begin(texel_count, part, part_count); i < end; ++i) {
    step[i] += alpha * p[i];
    const float4 residual = r[i] - alpha * q[i];
    const float4 preconditioned = inverse_diagonal[i] * residual;
    r[i] = residual;
    z[i] = preconditioned;
    product += residual * preconditioned;
    norm += residual * residual;
  }
  parts[part] = product;
  norms[part] = norm;
}

// p = z + beta p. One work-item = one texel; global size texel_count.
__kernel void advance_direction(__global float4* p, __global const float4* z, float4 beta, int texel_count) {
  const int i = (int)get_global_id(0);
  if (i >= texel_count) return;
  p[i] = z[i] + beta * p[i];
}
