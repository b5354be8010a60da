// SPDX-License-Identifier: Apache-2.0
// Reads the shares of a map as the levels that they are of: a bake of them has nothing left to fit.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/image/plane_store.h"

namespace multum {

class GatheredShards {
 public:
  /// Shares 0 to `count` of `output`, whose rows depend on `key`. Throws Error(kEnvironment) that lists every share
  /// that is missing or of something else, or has not all of its rows.
  GatheredShards(std::string output, int count, const std::string& key, const PlaneStore& normals,
                 const FeaturePlanes& features, const MovmfSettings& settings);

  /// Rows of lobes of a level, and of features where there are any. Quick where rows are read in order. Throws
  /// Error(kEnvironment) for damaged rows, naming the share.
  void read_lobes(int level, int first_row, int row_count, void* rows);
  void read_features(int level, int first_row, int row_count, void* rows);

 private:
  struct Block {
    ShardReader* share;
    std::size_t number;  // in the share
    int first_row, row_count;
  };
  struct Rows {  // of the block that was read last
    int level = -1, first_row = 0, row_count = 0;
    std::string bytes;
  };
  void read(int level, int first_row, int row_count, bool features, void* rows);
  void load(int level, int row);

  const std::string output_;
  std::vector<std::unique_ptr<ShardReader>> shares_;
  std::map<int, std::vector<Block>> blocks_;  // by level, in order of their rows
  std::size_t lobe_texel_bytes_, feature_texel_bytes_;
  std::map<int, std::size_t> widths_;  // by level
  Rows held_;
};

/// Removes their files.
void remove_shards(const std::string& output, int count);

}  // namespace multum
