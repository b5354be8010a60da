// SPDX-License-Identifier: Apache-2.0
// Initialises the lobes of each texel before an EM launch, and sums the alignment vectors of the texel's neighbours.
// The alignment is that of Han et al. 2007, section 7.3, in the order of docs/contributing/ALGORITHMS.md, "Order".

#include "device/done_neighbours.clh"
#include "device/level_window.clh"
#include "device/movmf_em.clh"
#include "shared/movmf_fit.h"
#include "shared/vmf_lobe.h"

#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

// Sums a_k mu_k over the done neighbours and the parent.
static LobeLanes alignment_sum(__global const float* alignment_vectors, const Places* places, LobeLanes parent) {
  LobeLanes sum = told_to_neighbours(parent);
  for (int n = 0; n < places->beside_max; ++n) {
    const LobeLanes told = gather(alignment_vectors, places->beside[n]);
    const int_v is_there = has_neighbour(places, n);
    sum.x += is_there ? told.x : (real_v)(0.0f);
    sum.y += is_there ? told.y : (real_v)(0.0f);
    sum.z += is_there ? told.z : (real_v)(0.0f);
  }
  sum.amplitude = (real_v)(0.0f);
  return sum;
}

// In movmf_start, one work-item handles every lobe of MULTUM_VECTOR_WIDTH slots. The global size is
// slot_count / MULTUM_VECTOR_WIDTH.
//   parent  [lobe][parent_window_rows * parent_width]   not read when parent_width == 0
//   level   [lobe][window_rows * width]                 done neighbours; the texel's own lobes when there is no parent
//   alignment_vectors [lobe][window_rows * width][4]    a_k mu_k of done neighbours
//   texel_list [slot]                                   window row * width + x, or -1
//   start   [group][lobe][MULTUM_START_PLANES][MULTUM_GROUP]
// Bound by ten scattered reads per lobe.
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
