// SPDX-License-Identifier: Apache-2.0
// Does the forward transforms of the animation codec (Hakura et al. 2000, section 4, "Encoding") for all textures of a
// chunk in one launch. Converts colours to three planes. Then applies block cosines (DCT-II, orthonormal) or one level
// of the biorthogonal 9/7 wavelets (Cohen, Daubechies and Feauveau 1992) by lifting (Daubechies and Sweldens 1998).
// host/fields/codec/decoder/block_dct.h and wavelet_transform.h define these transforms. The decoder has the inverse
// transforms.
//
// One work-item sums each coefficient in a fixed order, with explicit fma. Therefore the result is the same on every
// device with IEEE rounding, for any number of textures in a launch.

#include "device/numerics.clh"

#if MULTUM_VECTOR_WIDTH != 1
#error "image_transform has only a scalar variant"
#endif

#define MULTUM_DCT_SIDE_MAX 32

// Computes planes[p] = row p of the rotation times the colour - offset p.
// One work-item handles one texel of one texture. The global size is texture_count * texel_count.
//   textures [texture][texel][3]
//   axes     [3][4]                    a row of the rotation, then its plane's offset
//   planes   [texture][3][texel]       written
// The kernel is memory bound.
__kernel void colour_planes(__global const float* textures, __global const float* axes, __global float* planes,
                            int texture_count, int texel_count) {
  const int item = (int)get_global_id(0);
  if (item >= texture_count * texel_count) return;
  const int texture = item / texel_count, texel = item % texel_count;
  const float red = textures[3 * (size_t)item], green = textures[3 * (size_t)item + 1],
              blue = textures[3 * (size_t)item + 2];
  for (int p = 0; p < 3; ++p)
    planes[(3 * (size_t)texture + p) * texel_count + texel] =
        fma(axes[4 * p], red, fma(axes[4 * p + 1], green, fma(axes[4 * p + 2], blue, -axes[4 * p + 3])));
}

// The blocks of an image are stored row by row. Blocks at the right and lower borders extend beyond the image and
// repeat its outermost texels:
//
//     +----+----+--+ . .      side = 4, columns = 3
//     |  0 |  1 | 2|   .
//     +----+----+--+ . .

// Transforms rows: half[y][u] = sum over x of cosines[u][x] samples[y][x].
// One work-item handles one row of one block. The global size is image_count * columns * rows * side.
//   planes  [image][height][width]
//   cosines [side][side]                   row k: frequency k
//   half    [image][block][side][side]     written
// The kernel is memory bound.
__kernel void dct_rows(__global const float* planes, __global const float* cosines, __global float* half_way,
                       int image_count, int width, int height, int side) {
  const int item = (int)get_global_id(0);
  const int columns = (width + side - 1) / side, rows = (height + side - 1) / side;
  if (item >= image_count * columns * rows * side) return;
  const int block = item / side % (columns * rows), image = item / side / (columns * rows);
  const int left = block % columns * side, y = min(block / columns * side + item % side, height - 1);
  __global const float* row = planes + ((size_t)image * height + y) * width;
  float samples[MULTUM_DCT_SIDE_MAX];
  for (int x = 0; x < side; ++x) samples[x] = row[min(left + x, width - 1)];
  __global float* out = half_way + (size_t)item * side;
  for (int u = 0; u < side; ++u) {
    float sum = 0.0f;
    for (int x = 0; x < side; ++x) sum = fma(cosines[u * side + x], samples[x], sum);
    out[u] = sum;
  }
}

// Transforms columns: coefficients[v][u] = sum over y of cosines[v][y] half[y][u].
// One work-item handles one row of coefficients of one block. The global size is block_count * side.
//   half         [block][side][side]
//   coefficients [block][side][side]   written
// The kernel is memory bound.
__kernel void dct_columns(__global const float* half_way, __global const float* cosines, __global float* coefficients,
                          int block_count, int side) {
  const int item = (int)get_global_id(0);
  if (item >= block_count * side) return;
  const int v = item % side;
  __global const float* block = half_way + (size_t)(item - v) * side;
  float sums[MULTUM_DCT_SIDE_MAX];
  for (int u = 0; u < side; ++u) sums[u] = 0.0f;
  for (int y = 0; y < side; ++y) {
    const float cosine = cosines[v * side + y];
    for (int u = 0; u < side; ++u) sums[u] = fma(cosine, block[y * side + u], sums[u]);
  }
  __global float* out = coefficients + (size_t)item * side;
  for (int u = 0; u < side; ++u) out[u] = sums[u];
}

// Converts an index to a sample of a line of n >= 2 samples. The line is mirrored repeatedly at its outermost samples.
static int mirrored(int i, int n) {
  const int period = 2 * (n - 1);
  i = i % period;
  i = i < 0 ? i + period : i;
  return i < n ? i : period - i;
}

// Computes a level of the wavelet transform along lines: ceil(n / 2) low coefficients, then floor(n / 2) high ones.
// Each lifting step adds a multiple of both neighbours to every other sample. One work-item computes its part of every
// step from nine samples, so pairs of coefficients do not depend on one another:
//
//     samples       -4  -3  -2  -1   0   1   2   3   4     of sample 2k
//     predict        .   o   .   o   .   o   .   o   .     odd  += -1.586 (both neighbours)
//     update         .   .   o   .   o   .   o   .   .     even += -0.053 (...)
//     predict        .   .   .   o   .   o   .   .   .     odd  +=  0.883 (...)
//     update         .   .   .   .   o   .   .   .   .     even +=  0.444 (...)
//
// Lines are rows or columns of a rectangle at each image's corner. A line has `length` samples, at least 2, which are
// `stride` apart. Lines are `step` apart. One work-item handles one pair of one line of one image, which is low
// coefficient 2k and high coefficient 2k + 1. The last pair of an odd length has no high coefficient. The global size
// is image_count * line_count * ceil(length / 2). If lines are columns, neighbouring items are neighbouring columns.
//   samples      [image][image_texels]
//   coefficients [image][image_texels]   written, only inside the rectangle; must be another buffer
// The kernel is memory bound.
__kernel void wavelet_lift(__global const float* samples, __global float* coefficients, int image_count,
                           int image_texels, int line_count, int step, int length, int stride) {
  const int item = (int)get_global_id(0), pairs = (length + 1) / 2;
  if (item >= image_count * line_count * pairs) return;
  const int line = item % line_count, k = item / line_count % pairs, image = item / line_count / pairs;
  const size_t begin = (size_t)image * image_texels + (size_t)line * step;
  __global const float* in = samples + begin;
  float x[9];
  for (int j = 0; j < 9; ++j) x[j] = in[(size_t)mirrored(2 * k + j - 4, length) * stride];
  for (int j = 1; j < 9; j += 2) x[j] = fma(-1.586134342f, x[j - 1] + x[j + 1], x[j]);
  for (int j = 2; j < 8; j += 2) x[j] = fma(-0.05298011854f, x[j - 1] + x[j + 1], x[j]);
  for (int j = 3; j < 7; j += 2) x[j] = fma(0.8829110762f, x[j - 1] + x[j + 1], x[j]);
  x[4] = fma(0.4435068522f, x[3] + x[5], x[4]);
  __global float* out = coefficients + begin;
  out[(size_t)k * stride] = x[4] * 1.149604398f;
  if (2 * k + 1 < length) out[(size_t)(pairs + k) * stride] = x[5] * (1.0f / 1.149604398f);
}
