// SPDX-License-Identifier: Apache-2.0
// Bins the normals and features of coarse texels for all levels in two passes over the map. The first pass finds the
// axes of the grids, and the second pass fills the cells (kernels/movmf_binning.cl; docs/contributing/ALGORITHMS.md,
// "Binned normals").
#pragma once

#include <map>
#include <vector>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/pyramid/row_store.h"
#include "host/bakes/pyramid/row_window.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Bytes of the samples of a binned texel, with all its cells.
std::size_t binned_bytes(const MultumMovmfFit& fit);

/// The samples of the texels of one level, row by row and one texel after another, and the number of samples per texel.
/// Features belong to the same samples and are in the order of rgb_planes.
struct BinnedLevel {
  RowStore samples;
  RowStore counts;  // one number per texel
  std::vector<RowStore> rgb_planes;
};

/// Copies a level's samples, or a triple of its features, into a window that has room for all cells of each texel.
RowWindow::Fill fill_binned(const BinnedLevel& level, const RowStore& samples, std::size_t texel_bytes);

/// Bins the levels of `schedule` whose method is kBinned, for lobes of `representation`. Returns the result by level.
/// `features` are rgb_planes. The map is read in bands of at most `band_rows` rows, which do not change the result. If
/// one band holds all rows and `on_device` is not null, the map is read from the device. Throws Cancelled.
std::map<int, BinnedLevel> bin_levels(Device& device, const PlaneStore& normals,
                                      const std::vector<const PlaneStore*>& features, const MipSchedule& schedule,
                                      Representation representation, int band_rows, MapWindows* on_device,
                                      const SpillPolicy& spill, Progress* progress);

/// Returns the programs that bin_levels() needs. The result is empty if no level is binned.
std::vector<ProgramChoice> binning_programs(const MipSchedule& schedule, Representation representation,
                                            const LaunchShape& shape);

/// Returns the approximate number of bytes in the buffers of bin_levels().
std::uint64_t binning_bytes(const MipSchedule& schedule, int band_rows, int rgb_plane_count, const LaunchShape& shape);

}  // namespace multum
