// SPDX-License-Identifier: Apache-2.0
// Bakes what mixes linearly into a mip pyramid: every texel of every level is the plain average of what it covers of
// the finest. The map is read once, by bands of rows, whatever its size (host/bakes/pyramid/box_pyramid.h). What is
// averaged, and where it goes, is the representation's matter.
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
  int first_level = 0;  // the finest to make
};

/// Maps in memory as inputs, and the header of what is made of them: sizes and contents alone.
class AveragedMap {
 public:
  /// `albedo` may be null. Weights are the features of `inputs`, and must outlive it.
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

/// Counts and plan of a pass of averages: its part of a bake's report (host/bakes/bake/bake_report.h).
struct AverageReport {
  std::string plan;                  // bands and levels, a line
  std::uint64_t slopes_limited = 0;  // normals nearer to the horizon than slopes of moments go (kSlopeZMin)
};

/// Makes the planes that a representation averages, and takes their averages.
class AveragedPlanes {
 public:
  using MapPlanes = std::array<DeviceBuffer, 3>;  // x, y, z, or a triple of features

  virtual ~AveragedPlanes() = default;
  /// "moments", for the plan's text.
  virtual std::string name() const = 0;
  /// Number of planes without those of features (host/bakes/pyramid/feature_planes.h), which come last, three a triple.
  virtual int plane_count() const = 0;
  /// Launches what writes all planes but those of a band into `nodes` [plane][row][row_length].
  virtual void make_finest(const MapPlanes& normals, const DeviceBuffer& nodes, const MultumBoxBand& band) = 0;
  /// Sees the normals as they are read.
  virtual void see_normals(const std::array<const float*, 3>&, std::size_t) {}
  /// Takes rows as they are done: of each level in order from the top, levels in any order.
  virtual void add_level(const BoxRows& rows) = 0;
  /// Hears that all rows of a band were handed over; kernels may be launched again.
  virtual void end_band() {}
};

/// Averages the map into all levels, and fills AverageReport::plan. Throws Error(kUsage) for too little memory,
/// Error(kEnvironment) when disk or device refuse, Cancelled. Progress: a unit a texel of the map.
void average_map(Device& device, const AverageInputs& inputs, AveragedPlanes& planes, AverageReport& report,
                 Progress* progress);

}  // namespace multum
