// SPDX-License-Identifier: Apache-2.0
// Decides how work is divided for a device: every choice that depends on what the device is, in one place. No byte of a
// result depends on any of them.
//
//                            CPU                               others
//   variant of a kernel      16 lanes of a vector              one lane (MULTUM_VECTOR_WIDTH 1)
//   local size               1: a thread takes items in turn   64: two warps of NVIDIA, a wavefront of AMD; launches
//                                                              that ask for more get what the device has
//   EM of a texel            by one work-item                  by a team of 64 where texels are too few to keep the
//                                                              device busy by themselves (movmf_em_texels.cl)
//   cells of coarse texels   a table a chunk of columns        one table that all add to, where the device adds longs
//                                                              atomically (movmf_binning.cl)
//   copies                   none: buffers are mapped            of 32 MiB at most, while the host makes the next
//   rows fitted at once      what caches hold                  what an eighth of its memory holds: few, large launches
//
// Measured on an NVIDIA H100 (docs/evidence/GPU.md) and on PoCL with two cores (docs/evidence/BENCHMARKS.md).
#pragma once

#include <cstddef>
#include <cstdint>

#include "host/formats/opencl/device.h"

namespace multum {

struct LaunchShape {
  int vector_width;                   // of the kernels' fast variant
  std::size_t local_size;             // of launches that ask for none
  std::size_t team_texels_max;        // texels that teams fit when there are no more at once; 0: no teams
  int pack_parts;                     // work-items that line up the samples of one group of texels
  bool atomic_cells;                  // a texel has one table of cells
  int strip_texels;                   // that a work-item of the pyramid's kernels takes (texture inference)
  std::size_t strip_local_size;       // of these
  std::size_t staging_bytes;          // of one copy; 0: there are no copies
  std::uint64_t window_bytes_max;     // for rows that are fitted at once; 0: what --memory leaves
  std::uint64_t window_bytes_useful;  // more is no faster; 0: as caches have it (host/bakes/movmf/bake_plan.h)

  bool has_teams() const { return team_texels_max > 0; }
  /// Do teams fit so many texels at once, of at most so many samples each?
  bool fits_by_teams(std::size_t texels, int sample_capacity) const;

  static LaunchShape of(const DeviceInfo& info);
  /// Shape of an accelerator, tried on this device as if it were no CPU (`multum bake --scalar`).
  static LaunchShape of_accelerator(const DeviceInfo& info);
};

}  // namespace multum
