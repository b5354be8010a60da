// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <set>

namespace multum {

std::vector<std::vector<std::size_t>> make_chunks(const std::vector<double>& seconds, double chunk_seconds) {
  std::vector<std::vector<std::size_t>> chunks;
  std::size_t open = 0;  // index of the chunk that has room, plus one; 0 if there is none
  double filled = 0.0;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    if (seconds[i] < 0.0 || seconds[i] >= chunk_seconds) {
      chunks.push_back({i});
      continue;
    }
    if (open == 0 || filled + seconds[i] > chunk_seconds || chunks[open - 1].size() >= kChunkJobsMax) {
      chunks.emplace_back();
      open = chunks.size();
      filled = 0.0;
    }
    chunks[open - 1].push_back(i);
    filled += seconds[i];
  }
  return chunks;
}

std::chrono::seconds time_limit(const SlurmSettings& settings, double seconds, int attempt) {
  if (seconds < 0.0) return settings.time_max;
  const double wanted = settings.time_factor * seconds * std::ldexp(1.0, std::clamp(attempt - 1, 0, 20));
  return std::chrono::seconds(std::llround(std::clamp(wanted, static_cast<double>(settings.time_min.count()),
                                                      static_cast<double>(settings.time_max.count()))));
}

std::string PartKind::name() const {
  if (is_whole()) return "";
  return is_merge ? fmt::format("merge {}", count) : fmt::format("{}/{}", index, count);
}

std::string PartKind::log_prefix() const {
  if (is_whole()) return "";
  return is_merge ? "merge: " : fmt::format("share {}: ", name());
}

std::string PartKind::option() const {
  if (is_whole()) return "";
  return is_merge ? fmt::format("--merge={}", count) : fmt::format("--shard={}/{}", index, count);
}

PartKind parse_part(const std::string& name) {
  static const std::regex kShare(R"((\d{1,4})/(\d{1,4}))"), kMerge(R"(merge (\d{1,4}))");
  std::smatch found;
  if (std::regex_match(name, found, kShare)) return {std::stoi(found[1]), std::stoi(found[2]), false};
  if (std::regex_match(name, found, kMerge)) return {0, std::stoi(found[1]), true};
  return {};
}

std::vector<std::vector<SlurmPart>> in_arrays(std::vector<SlurmPart> bands, int array_size_max) {
  if (bands.empty()) return {};
  const bool are_within = std::all_of(
      bands.begin(), bands.end(), [&](const SlurmPart& band) { return parse_part(band.share).index < array_size_max; });
  const std::size_t most = are_within ? bands.size() : static_cast<std::size_t>(std::max(1, array_size_max));
  std::vector<std::vector<SlurmPart>> arrays;
  for (SlurmPart& band : bands) {
    if (arrays.empty() || arrays.back().size() == most) arrays.emplace_back();
    band.item = are_within ? parse_part(band.share).index : static_cast<int>(arrays.back().size());
    arrays.back().push_back(std::move(band));
  }
  return arrays;
}

std::vector<std::vector<SlurmPart>> share_batches(const SlurmPart& of_job, int count, const std::vector<int>& missing,
                                                  int array_size_max) {
  const auto part = [&](const PartKind& kind) {
    SlurmPart made = of_job;
    made.item = kind.index;
    made.share = kind.name();
    return made;
  };
  std::vector<std::vector<SlurmPart>> batches;
  std::vector<SlurmPart> bands;
  for (const int index : missing) {
    if (index == 0) batches.push_back({part({0, count, false})});
    else bands.push_back(part({index, count, false}));
  }
  for (std::vector<SlurmPart>& array : in_arrays(std::move(bands), array_size_max)) batches.push_back(std::move(array));
  batches.push_back({part({0, count, true})});
  return batches;
}

bool waits_for(const PartKind& part, const PartKind& other) {
  if (part.is_whole() || other.is_whole() || other.is_merge) return false;
  return part.is_merge || (part.is_band() && other.index == 0);
}

std::vector<int> named_shares(const std::string& message, int count) {
  static const std::regex kForm(R"(--shard (\d{1,4})/(\d{1,4}))");
  std::set<int> found;
  for (std::sregex_iterator at(message.begin(), message.end(), kForm), end; at != end; ++at)
    if (std::stoi((*at)[2]) == count && std::stoi((*at)[1]) <= count) found.insert(std::stoi((*at)[1]));
  return {found.begin(), found.end()};
}

}  // namespace multum
