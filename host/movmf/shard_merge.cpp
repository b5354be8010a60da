// SPDX-License-Identifier: Apache-2.0
#include "host/movmf/shard_merge.h"

#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "host/base/error.h"
#include "host/movmf/map_shard.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

struct LevelSize {
  int level, height;
  std::size_t lobe_row_bytes, feature_row_bytes;
};

void take_level(ShardReader& share, const LevelSize& size, BakeCheckpoint& checkpoint, const std::string& path) {
  share.read(size.level, [&](const ShardReader::Rows& rows) {
    const BakeCheckpoint::Level& level =
        checkpoint.open_level(size.level, size.height, size.lobe_row_bytes, size.feature_row_bytes);
    if (rows.first_row + rows.row_count <= level.rows_done) return;  // of a merge that was stopped
    if (rows.first_row != level.rows_done || rows.first_row + rows.row_count > size.height ||
        rows.lobe_row_bytes != size.lobe_row_bytes || rows.feature_row_bytes != size.feature_row_bytes)
      throw Error(ErrorCode::kEnvironment, path + ": has other rows than its share should");
    checkpoint.add_rows(size.level, rows.row_count, rows.lobes, rows.features);
  });
}

}  // namespace

void gather_shards(const std::string& output, int count, const std::string& key, const PlaneStore& normals,
                   const FeaturePlanes& features, const MovmfSettings& settings, BakeCheckpoint& checkpoint) {
  const MipSchedule schedule = make_mip_schedule(normals, settings);
  const int coarse_from = plan_shard(schedule, settings, {0, count}).coarse_from;
  std::vector<std::unique_ptr<ShardReader>> shares;
  std::string missing;
  for (int i = 0; i <= count; ++i) try {
      shares.push_back(std::make_unique<ShardReader>(output, MapShard{i, count}, key));
    } catch (const Error& error) {
      missing += (missing.empty() ? "" : "\n  ") + std::string(error.what());
    }
  if (!missing.empty()) throw Error(ErrorCode::kEnvironment, missing);
  const auto lobes = static_cast<std::size_t>(settings.lobe_count);
  for (const LevelSchedule& level : schedule.levels) {
    const auto width = static_cast<std::size_t>(level.fit.width);
    const LevelSize size = {level.level, level.fit.height, lobes * width * sizeof(MultumVmfLobe),
                            lobes * features.rgb_planes.size() * width * sizeof(glm::vec3)};
    const bool is_coarse = level.level >= coarse_from;
    for (int i = is_coarse ? 0 : 1; i <= (is_coarse ? 0 : count); ++i)
      take_level(*shares[static_cast<std::size_t>(i)], size, checkpoint, shard_path(output, {i, count}));
    if (!checkpoint.is_done(level.level))
      throw Error(ErrorCode::kEnvironment,
                  output + ": its shares have not all rows of level " + std::to_string(level.level));
  }
}

void remove_shards(const std::string& output, int count) {
  std::error_code ignored;
  for (int i = 0; i <= count; ++i) std::filesystem::remove(shard_path(output, {i, count}), ignored);
}

}  // namespace multum
