// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/gathered_shards.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <glm/vec3.hpp>

#include "host/foundation/base/error.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

GatheredShards::GatheredShards(std::string output, int count, const std::string& key, const PlaneStore& normals,
                               const FeaturePlanes& features, const MovmfSettings& settings)
    : output_(std::move(output)),
      lobe_texel_bytes_(static_cast<std::size_t>(settings.lobe_count) * sizeof(MultumVmfLobe)),
      feature_texel_bytes_(static_cast<std::size_t>(settings.lobe_count) * features.rgb_planes.size() *
                           sizeof(glm::vec3)) {
  const MipSchedule schedule = make_mip_schedule(normals, settings);
  const int coarse_from = plan_shard(schedule, settings, {0, count}).coarse_from;
  std::string missing;
  const auto miss = [&](const std::string& why) { missing += (missing.empty() ? "" : "\n  ") + why; };
  for (int i = 0; i <= count; ++i) {
    try {
      shares_.push_back(std::make_unique<ShardReader>(output_, MapShard{i, count}, key));
    } catch (const Error& error) {
      miss(error.what());
    }
  }
  for (const LevelSchedule& level : schedule.levels) {
    if (!missing.empty()) break;
    const auto width = static_cast<std::size_t>(level.fit.width);
    widths_[level.level] = width;
    std::vector<Block>& blocks = blocks_[level.level];
    int row = 0;
    const bool is_coarse = level.level >= coarse_from;
    for (int i = is_coarse ? 0 : 1; i <= (is_coarse ? 0 : count); ++i) {
      ShardReader& share = *shares_[static_cast<std::size_t>(i)];
      for (std::size_t b = 0; b < share.block_count(); ++b) {
        const ShardReader::Rows& rows = share.block(b);
        if (rows.level != level.level) continue;
        if (rows.first_row != row || rows.lobe_row_bytes != width * lobe_texel_bytes_ ||
            rows.feature_row_bytes != width * feature_texel_bytes_)
          miss(shard_path(output_, {i, count}) + ": has other rows than its share should");
        blocks.push_back({&share, b, rows.first_row, rows.row_count});
        row += rows.row_count;
      }
    }
    if (row != level.fit.height)
      miss(fmt::format("{}: its shares have not all rows of level {}", output_, level.level));
  }
  if (!missing.empty()) throw Error(ErrorCode::kEnvironment, missing);
}

void GatheredShards::load(int level, int row) {
  if (held_.level == level && held_.first_row <= row && row < held_.first_row + held_.row_count) return;
  const std::vector<Block>& blocks = blocks_.at(level);
  const auto behind = std::upper_bound(blocks.begin(), blocks.end(), row,
                                       [](int at, const Block& block) { return at < block.first_row; });
  MULTUM_CHECK(behind != blocks.begin());
  const Block& block = *(behind - 1);
  held_.level = -1;
  block.share->read_block(block.number, held_.bytes);
  held_.level = level;
  held_.first_row = block.first_row;
  held_.row_count = block.row_count;
}

void GatheredShards::read(int level, int first_row, int row_count, bool features, void* rows) {
  const std::size_t lobe_bytes = widths_.at(level) * lobe_texel_bytes_,
                    feature_bytes = widths_.at(level) * feature_texel_bytes_;
  const std::size_t row_bytes = features ? feature_bytes : lobe_bytes;
  auto* to = static_cast<unsigned char*>(rows);
  for (int row = first_row; row < first_row + row_count;) {
    load(level, row);
    const int count = std::min(first_row + row_count, held_.first_row + held_.row_count) - row;
    const std::size_t begin = (features ? lobe_bytes * static_cast<std::size_t>(held_.row_count) : 0) +
                              row_bytes * static_cast<std::size_t>(row - held_.first_row);
    const std::size_t bytes = row_bytes * static_cast<std::size_t>(count);
    std::memcpy(to, held_.bytes.data() + begin, bytes);
    to += bytes;
    row += count;
  }
}

void GatheredShards::read_lobes(int level, int first_row, int row_count, void* rows) {
  read(level, first_row, row_count, false, rows);
}

void GatheredShards::read_features(int level, int first_row, int row_count, void* rows) {
  read(level, first_row, row_count, true, rows);
}

void remove_shards(const std::string& output, int count) {
  std::error_code ignored;
  for (int i = 0; i <= count; ++i) std::filesystem::remove(shard_path(output, {i, count}), ignored);
}

}  // namespace multum
