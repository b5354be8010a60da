// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/work_shard.h"

#include <fmt/format.h>

#include <regex>

#include "host/foundation/base/error.h"

namespace multum {

WorkShard parse_work_shard(const std::string& option, const std::string& text) {
  static const std::regex kForm(R"((\d{1,6})(?:-(\d{1,6}))?/(\d{1,6}))");
  std::smatch found;
  WorkShard shard;
  if (std::regex_match(text, found, kForm)) {
    shard.first = std::stoi(found[1]);
    shard.last = found[2].matched ? std::stoi(found[2]) : shard.first;
    shard.count = std::stoi(found[3]);
    if (1 <= shard.first && shard.first <= shard.last && shard.last <= shard.count) return shard;
  }
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{} is '{}', expected I/N or I-J/N (shares I to J of N, from 1), for example 3/8", option, text));
}

WorkShard parse_merged_shard(const std::string& option, const std::string& text) {
  const WorkShard shard = parse_work_shard(option, text);
  if (shard.count <= kMergedSharesMax) return shard;
  throw Error(ErrorCode::kUsage, fmt::format("{} is '{}', expected at most {} shares, the limit of --merge", option,
                                             text, kMergedSharesMax));
}

std::string share_file(const std::string& output, int index, int count) {
  return fmt::format("{}.shard-{}-of-{}", output, index, count);
}

}  // namespace multum
