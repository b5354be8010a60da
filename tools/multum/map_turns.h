// SPDX-License-Identifier: Apache-2.0
// Does the same work for several maps, a few of them at the same time. A small map cannot keep all processors busy,
// because its coarse levels have few texels and its steps wait for each other. Output and log appear in the order of
// the maps.
#pragma once

#include <cstddef>
#include <cstdio>
#include <functional>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "tools/multum/commands.h"

namespace multum {

/// The things that the work for one map uses.
struct MapTurn {
  std::size_t map;     // the number of the map, from 0
  Device& device;      // used by no other map at the same time
  Progress* progress;  // of this map
  int threads;         // the number of threads for this map
  std::FILE* out;      // instead of stdout
  std::FILE* err;      // instead of stderr
};

struct MapTurns {
  std::size_t count;    // of maps
  int at_once;          // the number of maps at the same time, at least 1
  int threads;          // the number of threads for all of them together
  DeviceChoice device;  // each thread that works on maps opens its own device
};

/// Calls work(turn) once for each map. `device` is the device of the first maps. The first map is finished before the
/// others begin, so that kernels that are not in the cache are built only once. If `work` throws an exception, maps
/// that have begun are cancelled, and the exception is thrown again. Throws Cancelled.
void for_each_map(const MapTurns& turns, const CommonOptions& common, Device& device,
                  const std::function<void(const MapTurn& turn)>& work);

}  // namespace multum
