// SPDX-License-Identifier: Apache-2.0
// Starts the lobes of each texel before a launch of EM, and sums what its neighbours say. Alignment after Han et al.
// 2007, section 7.2, in the order of docs/ALGORITHMS.md, "Order".

#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// The four colours (x & 1, y & 1) in the order in which they are fitted: diagonal neighbours first.
static int colour_rank(int x, int y) {
  const int colour = (x & 1) | ((y & 1) << 1);
  return colour == 0 ? 0 : colour == 3 ? 1 : colour == 1 ? 2 : 3;
}

static int fitted_before(int other_x, int other_y, int x, int y, int order) {
  if (other_x == x && other_y == y) return 0;
  // Across the border of a repeating map with an odd side lie texels of one colour: they change in the same step.
  if (order == MULTUM_ORDER_AGAIN) return colour_rank(other_x, other_y) != colour_rank(x, y);
  if (order == MULTUM_ORDER_SCANLINE) return other_y < y || (other_y == y && other_x < x);
  return colour_rank(other_x, other_y) < colour_rank(x, y);
}

// Lobes at `texels`.
static LobeLanes gather(__global const float* lobes, const int* texels) {
  float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH], a[MULTUM_VECTOR_WIDTH];
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const float4 lobe = vload4(texels[lane], lobes);
    x[lane] = lobe.x;
    y[lane] = lobe.y;
    z[lane] = lobe.z;
    a[lane] = lobe.w;
  }
  LobeLanes gathered;
  gathered.x = LOAD_V(x);
  gathered.y = LOAD_V(y);
  gathered.z = LOAD_V(z);
  gathered.amplitude = LOAD_V(a);
  return gathered;
}

// Where texels, their parents and their done neighbours lie in their windows.
typedef struct Places {
  int own[MULTUM_VECTOR_WIDTH];
  int parent[MULTUM_VECTOR_WIDTH];
  int beside[MULTUM_VECTOR_WIDTH][8];  // the done ones
  int beside_count[MULTUM_VECTOR_WIDTH];
} Places;

// The done neighbours of a texel that lies on no border, in the order of the loop in find_places(): a bit each, from
// (-1, -1) to (1, 1) by rows. All lanes of a launch by colours have one of them.
static uint done_mask(int x, int y, int order) {
  uint mask = 0;
  for (int i = 0; i < 9; ++i)
    if (fitted_before(x + i % 3 - 1, y + i / 3 - 1, x, y, order)) mask |= 1u << i;
  return mask;
}

static void find_places(__global const int* texels, const MultumMovmfFit* fit, Places* places) {
  uint mask = 0;
  int mask_colour = -1;
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    const int texel = max(texels[lane], 0), x = texel_column(texel, fit), y = texel_row(texel, fit);
    places->own[lane] = texel;
    places->parent[lane] = 0;
    places->beside_count[lane] = 0;
    if (fit->parent_width == 0) continue;
    const int parent_row =
        row_in_window(min(y >> 1, fit->parent_height - 1), fit->parent_first_row, fit->parent_height);
    places->parent[lane] = parent_row * fit->parent_width + min(x >> 1, fit->parent_width - 1);
    int count = 0;
    const int window_row = texel / fit->width;
    if (x > 0 && x + 1 < fit->width && y > 0 && y + 1 < fit->height && window_row > 0 &&
        window_row + 1 < fit->window_rows) {
      if (mask_colour != ((x & 1) | ((y & 1) << 1))) {
        mask_colour = (x & 1) | ((y & 1) << 1);
        mask = done_mask(x, y, fit->order);
      }
      for (int i = 0; i < 9; ++i)
        if ((mask >> i) & 1u) places->beside[lane][count++] = texel + (i / 3 - 1) * fit->width + i % 3 - 1;
      places->beside_count[lane] = count;
      continue;
    }
    for (int dy = -1; dy <= 1; ++dy) {
      const int ny = neighbour(y + dy, fit->height, fit->periodic_y);
      const int row = row_in_window(ny, fit->first_row, fit->height);
      if (ny < 0 || row >= fit->window_rows) continue;
      for (int dx = -1; dx <= 1; ++dx) {
        const int nx = neighbour(x + dx, fit->width, fit->periodic_x);
        if (nx >= 0 && fitted_before(nx, ny, x, y, fit->order)) places->beside[lane][count++] = row * fit->width + nx;
      }
    }
    places->beside_count[lane] = count;
  }
}

// What done neighbours and the parent say, summed: a_k mu_k.
static LobeLanes alignment_sum(__global const float* alignment_vectors, const Places* places, LobeLanes parent) {
  float x[MULTUM_VECTOR_WIDTH], y[MULTUM_VECTOR_WIDTH], z[MULTUM_VECTOR_WIDTH];
  const LobeLanes told = told_to_neighbours(parent);
  STORE_V(told.x, x);
  STORE_V(told.y, y);
  STORE_V(told.z, z);
  for (int lane = 0; lane < MULTUM_VECTOR_WIDTH; ++lane) {
    float4 sum = (float4)(x[lane], y[lane], z[lane], 0.0f);
    for (int n = 0; n < places->beside_count[lane]; ++n) sum += vload4(places->beside[lane][n], alignment_vectors);
    x[lane] = sum.x;
    y[lane] = sum.y;
    z[lane] = sum.z;
  }
  LobeLanes result;
  result.x = LOAD_V(x);
  result.y = LOAD_V(y);
  result.z = LOAD_V(z);
  result.amplitude = (real_v)(0.0f);
  return result;
}

// movmf_start: one work-item = MULTUM_VECTOR_WIDTH slots, every lobe; global size slot_count / MULTUM_VECTOR_WIDTH.
//   parent  [lobe][parent_window_rows * parent_width]   not read when parent_width == 0
//   level   [lobe][window_rows * width]                 done neighbours; the texel's own lobes when there is no parent
//   alignment_vectors [lobe][window_rows * width][4]              what done neighbours say
//   texel_list [slot]                                   window row * width + x, or -1
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]
// Bound by ten scattered reads a lobe.
__kernel void movmf_start(__global const MultumVmfLobe* parent, __global const MultumVmfLobe* level,
                          __global const float* alignment_vectors, __global const int* texel_list,
                          __global float* start, MultumMovmfFit fit) {
  const int slot = (int)get_global_id(0) * MULTUM_VECTOR_WIDTH;
  if (slot >= fit.slot_count) return;
  const size_t level_size = level_window_size(&fit), parent_size = parent_window_size(&fit);
  const bool has_parent = fit.parent_width > 0;
  const bool from_parent = has_parent && fit.order != MULTUM_ORDER_AGAIN;
  Places places;
  find_places(texel_list + slot, &fit, &places);
  __global float* out =
      start + (size_t)(slot / MULTUM_GROUP) * MULTUM_LOBES * MULTUM_START_PLANES * MULTUM_GROUP + slot % MULTUM_GROUP;
  for (int j = 0; j < MULTUM_LOBES; ++j, out += MULTUM_START_PLANES * MULTUM_GROUP) {
    LobeLanes from, prior;
    prior.x = prior.y = prior.z = (real_v)(0.0f);
    if (has_parent) {
      from = gather((__global const float*)(parent + j * parent_size), places.parent);
      prior = alignment_sum(alignment_vectors + j * level_size * 4, &places, from);
    }
    if (!from_parent) from = gather((__global const float*)(level + j * level_size), places.own);

    const LobeStart lobe = start_of_lobe(from);
    real_v kappa = lobe.kappa;
    real_v amplitude = from.amplitude;
    if (from_parent) {
      kappa *= fit.start_kappa_factor;
      amplitude = MAX_V(amplitude, (real_v)(fit.start_amplitude_min));
    }
    kappa = MIN_V(MAX_V(kappa, (real_v)(0.05f)), (real_v)(1e6f));
    STORE_V(lobe.x, out + (MULTUM_START_MU + 0) * MULTUM_GROUP);
    STORE_V(lobe.y, out + (MULTUM_START_MU + 1) * MULTUM_GROUP);
    STORE_V(lobe.z, out + (MULTUM_START_MU + 2) * MULTUM_GROUP);
    STORE_V(kappa * MULTUM_LOG2E * (1.0f + fit.extra_copies), out + MULTUM_START_SHARPNESS * MULTUM_GROUP);
    STORE_V(log_weight_of(MAX_V(amplitude, (real_v)(1e-6f)), kappa, fit.extra_copies),
            out + MULTUM_START_LOG * MULTUM_GROUP);
    STORE_V(prior.x * fit.alignment, out + (MULTUM_START_PRIOR + 0) * MULTUM_GROUP);
    STORE_V(prior.y * fit.alignment, out + (MULTUM_START_PRIOR + 1) * MULTUM_GROUP);
    STORE_V(prior.z * fit.alignment, out + (MULTUM_START_PRIOR + 2) * MULTUM_GROUP);
  }
}
