// SPDX-License-Identifier: Apache-2.0
// Bakes only the edited part of a map and takes the rest from the file that was baked before the edit. On every level,
// the texels of this part and a few texels around it are fitted again. Each texel starts from its parent, and unchanged
// texels of the old file are its neighbours. All other texels keep the values of the old file.
//
// This is an approximation. The coarsest texel starts from its old lobes instead of the candidates for the whole map,
// and texels outside the region keep their values (docs/contributing/ALGORITHMS.md, "Baking a region again").
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

/// Returns the smallest rectangle of level 0 that contains every changed texel. Changed texels differ from `old` by
/// more than two steps of 16-bit normals or of 16-bit floats. The rectangle's height is 0 if no texel differs. Returns
/// nullopt if `old` stores no level 0. `header` belongs to the file to write. `normals` and `features` are the data to
/// compare. Throws the same errors as RegionBake.
std::optional<MapRegion> find_changed_region(const std::string& old, const MovmfMipmap& header,
                                             const PlaneStore& normals, const FeaturePlanes& features, int threads);

/// Chooses the region to bake again. If `asked` is set, this is the region, otherwise the changed part. Throws
/// Error(kInput) if texels outside `asked` have changed, because they would keep their old values. Throws Error(kUsage)
/// if `asked` is not set and `old` stores no level 0.
MapRegion resolve_region(const std::optional<MapRegion>& asked, const std::string& input, const std::string& old,
                         const MovmfMipmap& header, const PlaneStore& normals, const FeaturePlanes& features,
                         int threads);

/// The number of texels on each side of a region that are also fitted again on every level, because the alignment prior
/// ties a texel to its neighbours.
constexpr int kRegionHalo = 2;

class RegionBake : public RowOrigin, public MovmfSink {
 public:
  /// `old` is the file to bake onto. `header` belongs to the file to write. The two files must agree in sizes, lobes,
  /// encoding, first level and colours. Throws Error(kInput) that names the file and the difference, and Error(kUsage)
  /// for a region outside the map.
  RegionBake(const std::string& old, const MovmfMipmap& header, const MapRegion& region, const SpillPolicy& spill,
             BakeOutput& output);

  std::optional<TexelRange> range(int level) const override { return texels(level); }
  LevelTask begin(const LevelShape& level) override;
  void end() override;
  void add_level(int level, int first_row, MovmfLevel rows) override;
  void add_finest(int first_row, MovmfFinest rows) override;
  /// Copies the rows of the old file after the last fitted rows.
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
  std::vector<int> next_row_;  // [level]: the first row that is not yet written
};

}  // namespace multum
