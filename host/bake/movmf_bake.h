// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of von Mises-Fisher mixtures (Han et al. 2007, section 7), or of mixtures of
// planar Gaussians (Tan et al. 2005; MovmfSettings::representation): every level is
// fitted to all normals that its texels cover, from the coarsest level to the finest, each texel started from its
// parent's lobes and held to its done neighbours' by the alignment prior, so that hardware filtering mixes lobes of one
// kind. One lobe a texel is its mean normal: averaged, not fitted (host/bake/movmf_average.h).
#pragma once

#include "host/asset/movmf_mipmap.h"
#include "host/bake/bake_report.h"
#include "host/bake/bake_settings.h"
#include "host/bake/movmf_fit.h"
#include "host/base/progress.h"
#include "host/image/material_maps.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"

namespace multum {

/// validate() and what the map's size sets limits to. Throws Error(kInput) for a map that is too large, Error(kUsage).
void validate(const MovmfSettings& settings, int map_width, int map_height);

/// What a bake reads, and what it may use.
struct MovmfBakeInputs {
  const PlaneStore* normals = nullptr;
  const PlaneStore* albedo = nullptr;                   // of the same size; null: no colours
  const WeightMap* weights = nullptr;                   // of the same size; null: none
  bool has_roughness = false;                           // normals are shortened (host/image/material_maps.h)
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for windows and buffers; changes no byte of the result
  std::uint64_t writer_bytes = 0;                       // of these, what the sink holds while levels are fitted
  StorePlace place;                                     // of what does not fit in memory
  int threads = 1;                                      // of the host's own loops
  BakeCheckpoint* checkpoint = nullptr;                 // null: nothing is kept for another process
  const RegionInputs* region = nullptr;                 // null: the whole map
};

/// Hands rows to `sink` as they are done, exact to float, not yet rounded to what the file stores (quantize_movmf).
/// Counts and times go to `report`. Throws Error(kUsage) for settings out of range and for too little memory,
/// Error(kEnvironment) when the disk or the device refuses, Cancelled.
void bake_movmf(Device& device, const MovmfBakeInputs& inputs, const MovmfSettings& settings, MovmfSink& sink,
                BakeReport& report, Progress* progress);

/// The same as a whole, of planes or of maps in memory. Of levels finer than settings.first_level there are sizes
/// alone.
MovmfMipmap bake_movmf(Device& device, const MovmfBakeInputs& inputs, const MovmfSettings& settings, BakeReport& report,
                       Progress* progress);
/// `albedo` may be null.
MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       BakeReport& report, Progress* progress);

/// Units of progress that bake_movmf() advances by.
std::uint64_t movmf_bake_units(int width, int height, int first_level = 0);

}  // namespace multum
