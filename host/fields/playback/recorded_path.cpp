// SPDX-License-Identifier: Apache-2.0
#include "host/fields/playback/recorded_path.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

using nlohmann::json;

constexpr std::size_t kPositionsLeast = 2, kPositionsMost = 100000;  // the same limits as in recorded_path.js
constexpr std::int64_t kFileBytesMax = std::int64_t{64} << 20;       // room for this many positions, indented

[[noreturn]] void refuse_path(const std::string& what) { throw Error(ErrorCode::kInput, what); }

std::vector<double> position_from(const json& list, std::size_t number, std::size_t parameter_count) {
  if (!list.is_array() || list.size() != parameter_count + 1 ||
      !std::all_of(list.begin(), list.end(), [](const json& one) { return one.is_number(); }))
    refuse_path(
        fmt::format("position {} is {}, expected a list of {} numbers: seconds, and an index along each "
                    "parameter",
                    number, list.dump().substr(0, 40), parameter_count + 1));
  return list.get<std::vector<double>>();
}

}  // namespace

RecordedPath::RecordedPath(const std::string& text, const std::vector<std::string>& names) {
  if (holds_nul(text)) refuse_path("contains a NUL in a text");
  const json file = json::parse(text, nullptr, false);
  if (file.is_discarded()) refuse_path("is not JSON, expected a path that the player page saved");
  if (!file.is_object() || !file.contains("multumPath")) refuse_path("is not a path, expected \"multumPath\": 1");
  if (file["multumPath"] != 1)
    refuse_path(fmt::format("has \"multumPath\": {}, expected 1: a newer multum may have saved it",
                            file["multumPath"].dump().substr(0, 40)));
  const json parameters = file.value("parameters", json());
  if (parameters != json(names))
    refuse_path(fmt::format("is a path through {}, expected the field's parameters {}",
                            parameters.dump().substr(0, 200), json(names).dump()));
  const json positions = file.value("positions", json());
  if (!positions.is_array() || positions.size() < kPositionsLeast || positions.size() > kPositionsMost)
    refuse_path(fmt::format("has {} positions, expected {} to {}", positions.is_array() ? positions.size() : 0,
                            kPositionsLeast, kPositionsMost));
  for (const json& list : positions) {
    std::vector<double> position = position_from(list, times_.size(), names.size());
    if (!times_.empty() && position[0] < times_.back())
      refuse_path(fmt::format("position {} is at {} s, after a position at {} s; expected seconds in ascending order",
                              times_.size(), position[0], times_.back()));
    times_.push_back(position[0]);
    position.erase(position.begin());
    positions_.push_back(std::move(position));
  }
  if (!std::isfinite(seconds())) refuse_path("has a duration that is not a finite number of seconds");
}

std::vector<double> RecordedPath::at(double seconds) const {
  const double whole = this->seconds();
  const double time = times_.front() + (whole > 0.0 ? std::fmod(seconds, whole) : 0.0);
  const auto later = std::upper_bound(times_.begin(), times_.end(), time);
  const std::size_t next =
      std::clamp<std::size_t>(static_cast<std::size_t>(later - times_.begin()), 1, times_.size() - 1);
  const double span = times_[next] - times_[next - 1];
  const double share = span > 0.0 ? (time - times_[next - 1]) / span : 0.0;
  std::vector<double> result = positions_[next - 1];
  for (std::size_t p = 0; p < result.size(); ++p) result[p] += share * (positions_[next][p] - result[p]);
  return result;
}

bool is_recorded_path(const std::string& path) { return path.ends_with(".json"); }

RecordedPath read_recorded_path(const std::string& path, const std::vector<std::string>& names) {
  ByteFile file(path);
  if (file.size() > kFileBytesMax)
    throw Error(ErrorCode::kInput, fmt::format("{}: has {} bytes, expected a recorded path of up to {}", path,
                                               file.size(), kFileBytesMax));
  try {
    return RecordedPath(file.bytes(0, file.size(), "the path"), names);
  } catch (const Error& error) {
    throw Error(error.code(), path + ": " + error.what());
  }
}

}  // namespace multum
