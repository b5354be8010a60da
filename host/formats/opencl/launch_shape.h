// SPDX-License-Identifier: Apache-2.0
// Divides work for a device. Every choice that depends on the kind of device is here; no choice changes a byte of the
// result.
//
//                            CPU                               others
//   variant of a kernel      16 lanes of a vector              one lane (MULTUM_VECTOR_WIDTH 1)
//   local size               1: a thread takes items in turn   64: two warps of NVIDIA, a wavefront of AMD; larger
//                                                              requests get the device's maximum
//   EM of a texel            by one work-item                  by a team of 64 if there are too few texels to keep the
//                                                              device busy (movmf_em_texels.cl)
//   cells of coarse texels   a table per chunk of columns      one shared table, if the device adds longs atomically
//                                                              (movmf_binning.cl)
//   copies                   none: buffers are mapped          at most 32 MiB each; the host prepares the next one
//   rows fitted at once      as many as caches hold            an eighth of the device's memory: few, large launches
//
// The choices were measured on an NVIDIA H100 (docs/evidence/GPU.md) and on PoCL with two cores
// (docs/evidence/BENCHMARKS.md).
#pragma once

#include <cstddef>
#include <cstdint>

#include "host/formats/opencl/device.h"

namespace multum {

struct LaunchShape {
  int vector_width;                   // vector width of the kernels' fast variant
  std::size_t local_size;             // default local size of launches
  std::size_t team_texels_max;        // largest number of texels that teams fit at once; 0 if teams are not used
  int pack_parts;                     // number of work-items that arrange the samples of a group of texels
  bool atomic_cells;                  // true if all chunks of a texel share one table of cells
  int strip_texels;                   // texels per work-item in the pyramid's kernels (texture inference)
  std::size_t strip_local_size;       // local size of the pyramid's kernels
  std::size_t staging_bytes;          // number of bytes of one copy; 0 if nothing is copied
  std::uint64_t window_bytes_max;     // limit on the bytes of rows that are fitted at once; 0 if --memory is the limit
  std::uint64_t window_bytes_useful;  // bytes of rows fitted at once that suffice for full speed; if 0, the cache size
                                      // decides (host/bakes/movmf/bake_plan.h)

  bool has_teams() const { return team_texels_max > 0; }
  /// Returns whether teams fit this many texels at once, with at most `sample_capacity` samples each.
  bool fits_by_teams(std::size_t texels, int sample_capacity) const;

  static LaunchShape of(const DeviceInfo& info);
  /// Returns the shape for accelerators. `multum bake --scalar` uses it on any device, even a CPU.
  static LaunchShape of_accelerator(const DeviceInfo& info);
};

}  // namespace multum
