// SPDX-License-Identifier: Apache-2.0
// Computes per-lobe colours, weights of basis BRDFs and other linear material features as a_j y_j = sum_i z_ij y_i / N.
// The responsibilities come from the E-step that gave the stored amplitudes, so the sum over lobes is exactly the
// texel's mean (Han et al. 2007, section 7.3). The kernel handles three channels at a time, which are a colour or three
// of the weights.

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "device/texel_coverage.clh"
#include "shared/movmf_fit.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// Computes the responsibilities z_ij of one normal or of one mean of normals. `lobes` is the `start` of one slot in
// movmf_em_texels.
static void responsibilities(float nx, float ny, float nz, __global const float* lobes, float* z) {
#define PARAMETER(j, plane) lobes[((j)*MULTUM_START_PLANES + (plane)) * MULTUM_GROUP]
  float largest = -1e30f, total = 0.0f;
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    const float u = sample_gap(PARAMETER(j, MULTUM_START_MU), PARAMETER(j, MULTUM_START_MU + 1),
                               PARAMETER(j, MULTUM_START_MU + 2), nx, ny, nz);
    z[j] = fma(-PARAMETER(j, MULTUM_START_SHARPNESS), u, PARAMETER(j, MULTUM_START_LOG));
    largest = MAX_V(largest, z[j]);
  }
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    z[j] = exp2_v(z[j] - largest);
    total += z[j];
  }
  for (int j = 0; j < MULTUM_LOBES; ++j) z[j] /= total;
}

static __global const float* lobes_of_slot(__global const float* start, int slot) {
  return start + (size_t)(slot / MULTUM_GROUP) * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP +
         slot % MULTUM_GROUP;
}

// One work-item handles one chunk of rows of one slot. The global size is chunk_count * slot_count.
//   normal_x, normal_y, normal_z, value_x, value_y, value_z [rows * map_width]  as in movmf_em_partial
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]  output of the EM kernels
//   partial [slot][chunk][lobe][3]                            written
// The kernel is compute bound: one exponential per lobe and sample.
__kernel void movmf_feature_partial(__global const float* normal_x, __global const float* normal_y,
                                    __global const float* normal_z, __global const float* value_x,
                                    __global const float* value_y, __global const float* value_z,
                                    __global const float* start, __global const int* texel_list,
                                    __global float* partial, MultumMovmfFit fit) {
  const int item = (int)get_global_id(0);
  const int slot = item / fit.chunk_count, chunk = item % fit.chunk_count;
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[slot];
  if (texel < 0) return;
  const int x = texel_column(texel, &fit), y = texel_row(texel, &fit);
  const int top_row = first_covered(y, fit.map_height, fit.height);
  const int first_row = top_row + chunk * fit.chunk_rows;
  const int last_row = min(min(first_row + fit.chunk_rows, top_row + fit.sample_rows), fit.map_height);
  if (!in_map_window(min(first_row, fit.map_height - 1), &fit)) return;

  float sum[MULTUM_LOBES][3];
  for (int j = 0; j < MULTUM_LOBES; ++j) sum[j][0] = sum[j][1] = sum[j][2] = 0.0f;
  __global const float* lobes = lobes_of_slot(start, slot);
  const int first_column = first_covered(x, fit.map_width, fit.width);
  const int last_column = min(first_column + fit.sample_columns, fit.map_width);
  for (int row = first_row; row < last_row; ++row) {
    const float row_weight = coverage(row, y, fit.map_height, fit.height);
    for (int column = first_column; column < last_column; ++column) {
      const size_t source = map_row_start(row, &fit) + column;
      float z[MULTUM_LOBES];
      float nx = normal_x[source], ny = normal_y[source], nz = normal_z[source];
      TO_SAMPLE(float, nx, ny, nz, fit.shortened)
      responsibilities(nx, ny, nz, lobes, z);
      const float weight = row_weight * coverage(column, x, fit.map_width, fit.width);
      for (int j = 0; j < MULTUM_LOBES; ++j) {
        const float responsibility = z[j] * weight;
        sum[j][0] = fma(responsibility, value_x[source], sum[j][0]);
        sum[j][1] = fma(responsibility, value_y[source], sum[j][1]);
        sum[j][2] = fma(responsibility, value_z[source], sum[j][2]);
      }
    }
  }
  __global float* out = partial + (size_t)item * MULTUM_LOBES * 3;
  for (int j = 0; j < MULTUM_LOBES; ++j)
    for (int c = 0; c < 3; ++c) out[j * 3 + c] = sum[j][c];
}

// Adds the chunks.
// One work-item handles one lobe of one slot. The global size is MULTUM_LOBES * slot_count.
//   partial [slot][chunk][lobe][3]
//   features [plane][window_rows * width][3]   planes first_plane + lobe written: premultiplied by the amplitude
__kernel void movmf_feature_sum(__global const float* partial, __global const int* texel_list, __global float* features,
                                MultumMovmfFit fit, int first_plane) {
  const int item = (int)get_global_id(0);
  const int slot = item / MULTUM_LOBES, lobe = item % MULTUM_LOBES;
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[slot];
  if (texel < 0) return;
  float sum[3] = {0.0f, 0.0f, 0.0f}, carry[3] = {0.0f, 0.0f, 0.0f};
  for (int chunk = 0; chunk < fit.chunk_count; ++chunk) {
    __global const float* in = partial + (((size_t)slot * fit.chunk_count + chunk) * MULTUM_LOBES + lobe) * 3;
    for (int c = 0; c < 3; ++c) add_compensated(&sum[c], &carry[c], in[c]);
  }
  __global float* out = features + ((first_plane + lobe) * level_window_size(&fit) + texel) * 3;
  for (int c = 0; c < 3; ++c) out[c] = (sum[c] + carry[c]) * fit.total_weight_inverse;
}

// Computes the features of binned texels. One work-item handles one slot.
//   samples, value_samples [group][sample][4][MULTUM_GROUP] normals and features, whose cells have the same order
//   sample_counts [group]; start and features as above
__kernel void movmf_feature_binned(__global const float* samples, __global const float* value_samples,
                                   __global const int* sample_counts, __global const float* start,
                                   __global const int* texel_list, __global float* features, MultumMovmfFit fit,
                                   int first_plane) {
  const int slot = (int)get_global_id(0);
  if (slot >= fit.slot_count) return;
  const int texel = texel_list[slot];
  if (texel < 0) return;
  const size_t first = (size_t)(slot / MULTUM_GROUP) * fit.sample_capacity * 4 * MULTUM_GROUP + slot % MULTUM_GROUP;
  __global const float* lobes = lobes_of_slot(start, slot);
  float sum[MULTUM_LOBES][3];
  for (int j = 0; j < MULTUM_LOBES; ++j) sum[j][0] = sum[j][1] = sum[j][2] = 0.0f;
  for (int i = 0; i < sample_counts[slot / MULTUM_GROUP]; ++i) {
    __global const float* n = samples + first + (size_t)i * 4 * MULTUM_GROUP;
    __global const float* value = value_samples + first + (size_t)i * 4 * MULTUM_GROUP;
    float z[MULTUM_LOBES];
    responsibilities(n[0], n[MULTUM_GROUP], n[2 * MULTUM_GROUP], lobes, z);
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      const float responsibility = z[j] * n[3 * MULTUM_GROUP];
      for (int c = 0; c < 3; ++c) sum[j][c] = fma(responsibility, value[c * MULTUM_GROUP], sum[j][c]);
    }
  }
  for (int j = 0; j < MULTUM_LOBES; ++j)
    for (int c = 0; c < 3; ++c)
      features[((first_plane + j) * level_window_size(&fit) + texel) * 3 + c] = sum[j][c] * fit.total_weight_inverse;
}
