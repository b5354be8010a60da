// SPDX-License-Identifier: Apache-2.0
// Multiplies the filter matrix A, its stored transpose or A^T A by a list of colours (Hakura et al. 2000, section 3.2,
// eqs. 2 and 3). Handles three colours at once, because they share the matrix.
//
// Rows are stored in blocks of 8 entries, and the last block is padded with weights of 0. A trilinear row is one block,
// so a matrix with only such rows has the ELL format. Rows that are averages over sub-pixels have more blocks.

// One work-item handles one row. The global size is row_count.
//   block_begin [row_count + 1]   first block of each row
//   columns     [8 * blocks]      indices below the length of x
//   weights     [8 * blocks]
//   x           [columns]         three colours and 0
//   y           [row_count]       written
// The kernel is memory bound.
__kernel void filter_matrix_spmv(__global const uint* block_begin, __global const int* columns,
                                 __global const float* weights, __global const float4* x, __global float4* y,
                                 int row_count) {
  const int row = (int)get_global_id(0);
  if (row >= row_count) return;
  const uint end = block_begin[row + 1];
  float4 sum = (float4)(0.0f);
  for (uint block = block_begin[row]; block < end; ++block) {
    const int8 c = vload8(block, columns);
    const float8 w = vload8(block, weights);
    sum += (w.s0 * x[c.s0] + w.s1 * x[c.s1]) + (w.s2 * x[c.s2] + w.s3 * x[c.s3]) +
           ((w.s4 * x[c.s4] + w.s5 * x[c.s5]) + (w.s6 * x[c.s6] + w.s7 * x[c.s7]));
  }
  y[row] = sum;
}
