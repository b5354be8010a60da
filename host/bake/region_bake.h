// SPDX-License-Identifier: Apache-2.0
// Bakes an edited part of a map onto the file that was baked before the edit: its texels on every level, and a few
// around them, are fitted again, each from its parent and beside the old file's texels; all others keep the old file's
// values.
//
// It is an approximation: the coarsest texel starts from its old lobes, not from the whole map's candidates, and texels
// around the region stay as they were (docs/ALGORITHMS.md, "A region again").
#pragma once

#include <string>
#include <vector>

#include "host/asset/movmf_reader.h"
#include "host/bake/bake_output.h"
#include "host/bake/movmf_fit.h"

namespace multum {

/// Texels [x, x + width) x [y, y + height) of the finest level.
struct MapRegion {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Texels beyond a region's own that are fitted again on every level: what a texel's neighbours are held to.
constexpr int kRegionHalo = 2;

class RegionBake : public RegionInputs, public MovmfSink {
 public:
  /// `old` is the file to bake onto, `header` says what will be written: both must agree in sizes, lobes, encoding,
  /// first level and colours. Throws Error(kInput) naming the file and what differs, Error(kUsage) for a region that is
  /// not in the map.
  RegionBake(const std::string& old, const MovmfMipmap& header, const MapRegion& region, const StorePlace& place,
             BakeOutput& output);

  TexelRange range(int level) const override;
  RowStore kept(int level) const override;
  void add_level(int level, int first_row, MovmfLevel rows) override;
  void add_finest(int first_row, MovmfFinest rows) override;
  /// After the last rows: what the old file has behind them.
  void finish();

 private:
  void write_level(int level, int first_row, MovmfLevel rows);
  void write_finest(int first_row, MovmfFinest rows);
  void copy_level_until(int level, int row);
  void copy_finest_until(int row);

  mutable MovmfReader old_;
  const MovmfMipmap& header_;
  const MapRegion region_;
  const StorePlace place_;
  BakeOutput& output_;
  std::vector<int> next_row_;  // by level: the first row that is not written yet
};

}  // namespace multum
