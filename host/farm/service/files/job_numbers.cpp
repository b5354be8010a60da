// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/job_numbers.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

namespace multum {
namespace {

namespace fs = std::filesystem;

// Returns the number between `before` and `after`. Any text may follow `after`. Returns 0 if there is no number, or if
// it is too large.
std::int64_t number_in(const std::string& name, const std::string& before, const std::string& after) {
  constexpr std::int64_t kHighest = std::int64_t{1} << 52;  // JSON readers keep such integers exact
  if (!name.starts_with(before)) return 0;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(name.data() + before.size(), name.data() + name.size(), number);
  const bool is_one =
      error == std::errc() && name.substr(static_cast<std::size_t>(end - name.data())).starts_with(after);
  return is_one && number > 0 && number < kHighest ? number : 0;
}

}  // namespace

std::int64_t highest_job_number(const std::string& data) {
  std::int64_t highest = 0;
  std::error_code error;
  for (const fs::directory_entry& log : fs::directory_iterator(data + "/logs", error))
    highest = std::max(highest, number_in(log.path().filename().string(), "", ".log"));
  for (const fs::directory_entry& pictures : fs::directory_iterator(data + "/pictures", error))
    highest = std::max(highest, number_in(pictures.path().filename().string(), "", "-"));
  fs::recursive_directory_iterator entry(data + "/results", error), end;
  for (; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();  // .multum-INSTANCE-ID
    if (name.starts_with(".multum-")) highest = std::max(highest, number_in(name, name.substr(0, 17), ""));
  }
  return highest;
}

}  // namespace multum
