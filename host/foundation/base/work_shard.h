// SPDX-License-Identifier: Apache-2.0
// Divides a list of work among several processes. Each process derives its work from the number of its share, so the
// processes do not communicate.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace multum {

/// The shares from number `first` to number `last`, out of `count` shares. Numbers start at 1. Pieces are assigned to
/// shares in turn, so neighbouring pieces, which often have the same size, belong to different shares.
struct WorkShard {
  int first = 1, last = 1, count = 1;

  bool is_whole() const { return first == 1 && last == count; }
  /// Returns whether these shares contain piece number `piece`, counted from 0.
  bool has(std::size_t piece) const {
    const auto share = static_cast<int>(piece % static_cast<std::size_t>(count)) + 1;
    return first <= share && share <= last;
  }
};

/// Parses "3/8", or "3-5/8" for shares 3, 4 and 5. Throws Error(kUsage), which names `option`.
WorkShard parse_work_shard(const std::string& option, const std::string& text);

/// The largest number of shares in one merge.
inline constexpr int kMergedSharesMax = 4096;

/// Like parse_work_shard(), for shares that a merge combines. Also throws Error(kUsage) for more than kMergedSharesMax.
WorkShard parse_merged_shard(const std::string& option, const std::string& text);

/// Returns the file that a share of one map writes next to the output: OUTPUT.shard-3-of-8.
std::string share_file(const std::string& output, int index, int count);

/// Returns the pieces of these shares, in order.
template <typename Piece>
std::vector<Piece> pieces_of(const WorkShard& shard, std::vector<Piece> all) {
  std::vector<Piece> own;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (shard.has(i)) own.push_back(std::move(all[i]));
  return own;
}

}  // namespace multum
