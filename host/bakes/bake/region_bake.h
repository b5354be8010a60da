// SPDX-License-Identifier: Apache-2.0
// Bakes an edited part of a map onto the file that was baked before the edit: its texels on every level, and a few
// around them, are fitted again, each from its parent and beside the old file's texels; all others keep the old file's
// values.
//
// It is an approximation: the coarsest texel starts from its old lobes, not from the whole map's candidates, and texels
// around the region stay as they were (docs/contributing/ALGORITHMS.md, "A region again").
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_output.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/asset/lobes/movmf_reader.h"

namespace multum {

/// Texels [x, x + width) x [y, y + height) of the finest level.
struct MapRegion {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const MapRegion&) const = default;
};

/// The least rectangle that holds every texel of level 0 that is not as `old` stores it, by more than two steps of
/// normals of 16 bits or of halfs; no rows: none differs. Nothing: `old` stores no level 0. `header` and `normals`,
/// `features`: what will be written, and of what. Throws as RegionBake does.
std::optional<MapRegion> find_changed_region(const std::string& old, const MovmfMipmap& header,
                                             const PlaneStore& normals, const FeaturePlanes& features, int threads);

/// Chooses the region to bake again: `asked`, or what has changed. Throws Error(kInput) when more has changed than was
/// asked for, which would be kept as it was; Error(kUsage) when nothing was asked for and `old` stores no level 0.
MapRegion resolve_region(const std::optional<MapRegion>& asked, const std::string& input, const std::string& old,
                         const MovmfMipmap& header, const PlaneStore& normals, const FeaturePlanes& features,
                         int threads);

/// Texels beyond a region's own that are fitted again on every level: what a texel's neighbours are held to.
constexpr int kRegionHalo = 2;

class RegionBake : public RowOrigin, public MovmfSink {
 public:
  /// `old` is the file to bake onto, `header` says what will be written: both must agree in sizes, lobes, encoding,
  /// first level and colours. Throws Error(kInput) naming the file and what differs, Error(kUsage) for a region that is
  /// not in the map.
  RegionBake(const std::string& old, const MovmfMipmap& header, const MapRegion& region, const SpillPolicy& spill,
             BakeOutput& output);

  std::optional<TexelRange> range(int level) const override { return texels(level); }
  LevelTask begin(const LevelShape& level) override;
  void end() override;
  void add_level(int level, int first_row, MovmfLevel rows) override;
  void add_finest(int first_row, MovmfFinest rows) override;
  /// Copies what the old file has behind the last rows.
  void finish() override;

 private:
  TexelRange texels(int level) const;
  RowStore old_lobes(int level) const;
  void write_level(int level, int first_row, MovmfLevel rows);
  void write_finest(int first_row, MovmfFinest rows);
  void copy_level_until(int level, int row);
  void copy_finest_until(int row);

  mutable MovmfReader old_;
  const MovmfMipmap& header_;
  const MapRegion region_;
  BakeOutput& output_;
  std::vector<int> next_row_;  // by level: the first row that is not written yet
};

}  // namespace multum
