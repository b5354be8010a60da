// SPDX-License-Identifier: Apache-2.0
// Bins the normals (and features) of coarse texels while the map streams by, all levels in two passes: one for the axes
// of their grids, one for their cells (kernels/movmf_binning.cl; docs/contributing/ALGORITHMS.md, "Binned normals").
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

/// Bytes of the samples of a binned texel, all its cells.
std::size_t binned_bytes(const MultumMovmfFit& fit);

/// The samples of one level's texels by rows: those of the row's texels one after another, and how many each has.
/// Features go with the same samples, by rgb_planes.
struct BinnedLevel {
  RowStore samples;
  RowStore counts;  // an int a texel
  std::vector<RowStore> rgb_planes;
};

/// Puts a level's samples, or a triple of its features, into a window that has room for all cells of each texel.
RowWindow::Fill fill_binned(const BinnedLevel& level, const RowStore& samples, std::size_t texel_bytes);

/// Bins the levels of `schedule` whose method is kBinned, for lobes of `representation`; returns them by level.
/// `features` are rgb_planes. The map passes in bands of at most `band_rows` rows, which change nothing in the result;
/// where that is all of them, and the map is `on_device` already (null: it is not), it is taken from there. Throws
/// Cancelled.
std::map<int, BinnedLevel> bin_levels(Device& device, const PlaneStore& normals,
                                      const std::vector<const PlaneStore*>& features, const MipSchedule& schedule,
                                      Representation representation, int band_rows, MapWindows* on_device,
                                      const SpillPolicy& spill, Progress* progress);

/// The programs that bin_levels() needs; none where no level is binned.
std::vector<ProgramChoice> binning_programs(const MipSchedule& schedule, Representation representation,
                                            const LaunchShape& shape);

/// Bytes of the buffers of bin_levels(), about.
std::uint64_t binning_bytes(const MipSchedule& schedule, int band_rows, int rgb_plane_count, const LaunchShape& shape);

}  // namespace multum
