// SPDX-License-Identifier: Apache-2.0
// Inputs of a bake of lobes, and its units of progress: for host/movmf/movmf_bake.h and movmf_average.h.
#pragma once

#include <cstdint>

#include "host/image/material_maps.h"
#include "host/image/plane_store.h"
#include "host/movmf/bake_checkpoint.h"
#include "host/movmf/movmf_fit.h"

namespace multum {

/// Maps that a bake reads, and the memory and threads that it may use.
struct MovmfBakeInputs {
  const PlaneStore* normals = nullptr;
  const PlaneStore* albedo = nullptr;                   // of the same size; null: no colours
  const WeightMap* weights = nullptr;                   // of the same size; null: none
  bool has_roughness = false;                           // normals are shortened (host/image/material_maps.h)
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for windows and buffers; changes no byte of the result
  std::uint64_t writer_bytes = 0;                       // of these, what the sink holds while levels are fitted
  SpillPolicy spill{.memory_bytes = 4 << 20};           // of what does not fit in memory
  int threads = 1;                                      // of the host's own loops
  BakeCheckpoint* checkpoint = nullptr;                 // null: nothing is kept for another process
  const RegionInputs* region = nullptr;                 // null: the whole map
};

/// Units of progress that a bake of lobes advances by.
std::uint64_t movmf_bake_units(int width, int height, int first_level = 0);

}  // namespace multum
