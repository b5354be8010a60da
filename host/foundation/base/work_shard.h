// SPDX-License-Identifier: Apache-2.0
// Divides a list of work among several processes, which need not know of one another: a share is what its number says.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace multum {

/// Shares first to last of count, from 1. Pieces are dealt out in turn, so that neighbours, which are often of one
/// size, go to different shares.
struct WorkShard {
  int first = 1, last = 1, count = 1;

  bool is_whole() const { return first == 1 && last == count; }
  /// Of the piece of that number, from 0.
  bool has(std::size_t piece) const {
    const auto share = static_cast<int>(piece % static_cast<std::size_t>(count)) + 1;
    return first <= share && share <= last;
  }
};

/// "3/8", or "3-5/8" for shares 3, 4 and 5. Throws Error(kUsage) that names `option`.
WorkShard parse_work_shard(const std::string& option, const std::string& text);

/// Shares that one merge puts together, at most.
inline constexpr int kMergedSharesMax = 4096;

/// The same of shares that a merge follows. Throws Error(kUsage) for more of them, too.
WorkShard parse_merged_shard(const std::string& option, const std::string& text);

/// The file of a share of one map, beside its output: OUTPUT.shard-3-of-8.
std::string share_file(const std::string& output, int index, int count);

/// Its pieces, in order.
template <typename Piece>
std::vector<Piece> pieces_of(const WorkShard& shard, std::vector<Piece> all) {
  std::vector<Piece> own;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (shard.has(i)) own.push_back(std::move(all[i]));
  return own;
}

}  // namespace multum
