// SPDX-License-Identifier: Apache-2.0
#include "host/service/staging.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <filesystem>

#include "host/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

std::string prefix_of(const std::string& instance) { return ".multum-" + instance + "-"; }

void sync_folder(const std::string& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) fail_by_errno(path, "cannot be opened");
  const int result = ::fsync(folder);
  ::close(folder);
  if (result != 0) fail_by_errno(path, "cannot be synced");
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(fs::symlink_status(path, ignored));
}

}  // namespace

std::string staging_folder(const std::string& output, const std::string& instance, std::int64_t id) {
  return (fs::path(output).parent_path() / (prefix_of(instance) + std::to_string(id))).string();
}

std::string staged_path(const std::string& output, const std::string& instance, std::int64_t id) {
  return (fs::path(staging_folder(output, instance, id)) / fs::path(output).filename()).string();
}

std::string file_identity(const std::string& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return "";
  if (S_ISDIR(found.st_mode)) return fmt::format("{}", found.st_ino);
  return fmt::format("{}:{}:{}", found.st_ino, found.st_size,
                     found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec);
}

void publish(const std::string& output, const std::string& instance, std::int64_t id, const std::string& identity) {
  const std::string staged = staged_path(output, instance, id);
  if (file_identity(staged) == identity) {
    // Two folders change places: an exchange is the only rename of a folder onto one that is not empty.
    const unsigned flags = is_folder(staged) && is_folder(output) ? RENAME_EXCHANGE : 0;
    if (::renameat2(AT_FDCWD, staged.c_str(), AT_FDCWD, output.c_str(), flags) != 0)
      fail_by_errno(output, "the result cannot be given its name");
  } else if (file_identity(output) != identity) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: the finished result is neither there nor in {}", output, staged));
  }
  sync_folder(fs::path(output).parent_path().string());
  remove_staging(output, instance, id);
}

void remove_staging(const std::string& output, const std::string& instance, std::int64_t id) {
  std::error_code ignored;
  fs::remove_all(staging_folder(output, instance, id), ignored);
}

std::vector<std::string> sweep_staging(const std::vector<std::string>& folders, const std::string& instance,
                                       const std::function<bool(std::int64_t)>& is_finished_with) {
  std::vector<std::string> removed;
  const std::string prefix = prefix_of(instance);
  for (const std::string& folder : folders) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(prefix)) continue;
      std::int64_t id = 0;
      const char* end = name.data() + name.size();
      const auto [stop, failed] = std::from_chars(name.data() + prefix.size(), end, id);
      if (failed != std::errc() || stop != end || !is_finished_with(id)) continue;
      fs::remove_all(entry.path(), error);
      if (!error) removed.push_back(entry.path().string());
    }
  }
  return removed;
}

}  // namespace multum
