// SPDX-License-Identifier: Apache-2.0
// Bakes linear quantities into a mip pyramid. Every texel of every level is the plain average of the finest texels that
// it covers. A map of any size is read once, in bands of rows (host/bakes/pyramid/box_pyramid.h). The representation
// defines which values are averaged and where they are stored.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "host/bakes/pyramid/box_pyramid.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "kernels/shared/mip_box.h"

namespace multum {

struct AverageInputs : MapInputs {
  int first_level = 0;  // the finest level to make
};

/// Wraps maps in memory as inputs. Also holds the header of the result, which has only sizes and contents.
class AveragedMap {
 public:
  /// `albedo` may be null. Weights are the features of `inputs`, and must outlive the object.
  AveragedMap(const NormalMap& map, const ColourMap* albedo, const AverageInputs& inputs);
  AveragedMap(const AveragedMap&) = delete;
  AveragedMap& operator=(const AveragedMap&) = delete;

  const AverageInputs& inputs() const { return inputs_; }
  BakedHeader header(Representation representation) const;

 private:
  const PlaneStore normals_;
  const std::optional<PlaneStore> albedo_;
  AverageInputs inputs_;
};

/// Counts and plan of an averaging pass, which are part of a bake's report (host/bakes/bake/bake_report.h).
struct AverageReport {
  std::string plan;                  // the bands and levels, in one line
  std::uint64_t slopes_limited = 0;  // normals too close to the horizon for slopes of moments (kSlopeZMin)
};

/// Makes the planes that a representation averages, and receives the averages.
class AveragedPlanes {
 public:
  using MapPlanes = std::array<DeviceBuffer, 3>;  // x, y, z, or a triple of features

  virtual ~AveragedPlanes() = default;
  /// Name in the plan's text, such as "moments".
  virtual std::string name() const = 0;
  /// Number of planes, not counting feature planes (host/bakes/pyramid/feature_planes.h). Feature planes come last,
  /// three per triple.
  virtual int plane_count() const = 0;
  /// Launches kernels that write a band of all planes except feature planes to `nodes` [plane][row][row_length].
  virtual void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) = 0;
  /// Receives each band of normals when it is read.
  virtual void see_normals(const std::array<const float*, 3>&, std::size_t) {}
  /// Receives finished rows. The rows of a level arrive in order from the top. Levels can arrive in any order.
  virtual void add_level(const BoxRows& rows) = 0;
  /// Called after all rows of a band have been handed over. Kernels may then be launched again.
  virtual void end_band() {}
};

/// Averages the map into all levels, and fills AverageReport::plan. Throws Error(kUsage) for too little memory,
/// Error(kEnvironment) for errors of the disk or the device, and Cancelled. Progress: one unit per texel of the map.
void average_map(Device& device, const AverageInputs& inputs, AveragedPlanes& planes, AverageReport& report,
                 Progress* progress);

}  // namespace multum
