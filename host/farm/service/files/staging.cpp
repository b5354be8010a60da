// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/staging.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

std::string prefix_of(const std::string& instance) { return ".multum-" + instance + "-"; }

std::string identity_of(const struct stat& found) {
  if (S_ISDIR(found.st_mode)) return fmt::format("{}", found.st_ino);
  return fmt::format("{}:{}:{}", found.st_ino, found.st_size,
                     found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec);
}

// Returns the state of the entry with this name, without following a link.
std::optional<struct stat> state_of(int folder, const std::string& name) {
  struct stat found {};
  if (::fstatat(folder, name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0) return std::nullopt;
  return found;
}

std::string identity_at(int folder, const std::string& name) {
  const std::optional<struct stat> found = state_of(folder, name);
  return found && (S_ISDIR(found->st_mode) || S_ISREG(found->st_mode)) ? identity_of(*found) : "";
}

// Returns a path to the open folder, for functions that need a path.
std::string name_of(const OpenFile& folder) { return fmt::format("/proc/self/fd/{}", folder.descriptor()); }

// Does not touch entries that belong to other users.
bool remove_staging(const OpenFile& folder, const std::string& name, const std::string& path) {
  try {
    const OpenFile staging = find_own_folder(folder, name, path);
    return staging.is_open() && remove_own_folder(folder, name, staging);
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::string staging_folder(const std::string& output, const std::string& instance, std::int64_t id) {
  return (fs::path(output).parent_path() / (prefix_of(instance) + std::to_string(id))).string();
}

std::string staged_path(const std::string& output, const std::string& instance, std::int64_t id) {
  return (fs::path(staging_folder(output, instance, id)) / fs::path(output).filename()).string();
}

std::string staged_name(const std::string& output) { return "./" + fs::path(output).filename().string(); }

OpenFile open_staging_folder(const PathRoots& roots, const std::string& path) {
  const OpenFile above = roots.open_folder_of(path);
  while (true) {
    OpenFile staging = open_own_folder(above, fs::path(path).filename().string(), path);
    if (mark_own_folder(staging, path)) return staging;
  }
}

std::string file_identity(const std::string& path) {
  struct stat found {};
  return ::stat(path.c_str(), &found) == 0 ? identity_of(found) : "";
}

namespace {

// Opens the folder of a result. Returns nullopt if it is missing or behind a symbolic link.
std::optional<OpenFile> open_place(const PathRoots& roots, const std::string& path) {
  try {
    return roots.open_folder_of(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUsage) throw;
    return std::nullopt;
  }
}

}  // namespace

std::string result_identity(const PathRoots& roots, const std::string& path) {
  const std::optional<OpenFile> folder = open_place(roots, path);
  return folder ? identity_at(folder->descriptor(), fs::path(path).filename().string()) : "";
}

bool is_as_made(const PathRoots& roots, const std::string& path, const std::string& identity, const ResultSeal& seal) {
  const std::optional<OpenFile> folder = open_place(roots, path);
  if (identity.empty() || !folder) return false;
  const std::string name = fs::path(path).filename().string();
  const std::optional<struct stat> found = state_of(folder->descriptor(), name);
  if (!found || identity_at(folder->descriptor(), name) != identity) return false;
  return !S_ISDIR(found->st_mode) || is_as_published(name_of(*folder) + "/" + name, seal);
}

StagedResult::StagedResult(const PathRoots& roots, const std::string& output, const std::string& instance,
                           std::int64_t id, ResultSeal seal)
    : output_(output),
      name_(fs::path(output).filename().string()),
      staging_(prefix_of(instance) + std::to_string(id)),
      id_(id),
      seal_(std::move(seal)),
      folder_(roots.open_folder_of(output)) {}

OpenFile StagedResult::open_staging() const { return find_own_folder(folder_, staging_, staging_path()); }

std::string StagedResult::staging_path() const { return (fs::path(output_).parent_path() / staging_).string(); }

std::string StagedResult::identity() const {
  const OpenFile staging = open_staging();
  return staging.is_open() ? identity_at(staging.descriptor(), name_) : "";
}

void StagedResult::check_place(bool is_folder) const {
  const std::optional<struct stat> found = state_of(folder_.descriptor(), name_);
  if (!found) return;
  const auto refuse = [&](const std::string& why) { throw Error(ErrorCode::kUsage, output_ + ": " + why); };
  if (S_ISDIR(found->st_mode) && !is_folder) refuse("is a folder, expected a file or a new path");
  if (!S_ISDIR(found->st_mode) && is_folder) refuse("is a file, expected a folder or a new path");
  if (!is_folder) return;
  const std::string other = unlisted_in(name_of(folder_) + "/" + name_, seal_);
  if (!other.empty())
    refuse(fmt::format(
        "holds {}, which is not a result of this service, or has changed; expected an empty folder, an unchanged "
        "result, or a new path",
        other));
}

std::string StagedResult::publish(const std::string& identity) const {
  const int folder = folder_.descriptor();
  const OpenFile staging = open_staging();
  if (staging.is_open() && identity_at(staging.descriptor(), name_) == identity) {
    const bool is_folder = S_ISDIR(state_of(staging.descriptor(), name_)->st_mode);
    check_place(is_folder);
    if (is_folder) write_result_listing(name_of(staging) + "/" + name_, seal_);
    // Exchanges two folders, because a folder that is not empty cannot be replaced by a rename.
    const bool is_exchange = is_folder && state_of(folder, name_).has_value();
    if (::renameat2(staging.descriptor(), name_.c_str(), folder, name_.c_str(), is_exchange ? RENAME_EXCHANGE : 0) != 0)
      fail_by_errno(output_, "cannot rename the result");
  } else if (identity_at(folder, name_) != identity) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: the finished result is neither at this path nor in {}", output_, staging_));
  }
  // Empties the staging folder even if another step fails, because otherwise the next attempt would resume from its
  // contents.
  const int sync_error = ::fsync(folder) == 0 ? 0 : errno;
  const std::string kept = staging.is_open() ? put_aside(staging) : "";
  remove();
  if (sync_error != 0) {
    errno = sync_error;
    fail_by_errno(output_, "its folder cannot be synced");
  }
  return kept;
}

// After an exchange, the staging folder contains the previous folder. Removes the published files of the previous
// folder, and renames everything that was added to it since its publication.
std::string StagedResult::put_aside(const OpenFile& staging) const {
  const std::optional<struct stat> old = state_of(staging.descriptor(), name_);
  if (!old || !S_ISDIR(old->st_mode)) return "";
  try {
    if (remove_listed(name_of(staging) + "/" + name_, seal_)) return "";
  } catch (const Error&) {  // keeps files of unknown origin
  }
  constexpr int kNamesMax = 100;
  for (int i = 1; i <= kNamesMax; ++i) {
    const std::string kept = fmt::format("{}.kept-{}{}", name_, id_, i == 1 ? "" : fmt::format("-{}", i));
    if (::renameat2(staging.descriptor(), name_.c_str(), folder_.descriptor(), kept.c_str(), RENAME_NOREPLACE) == 0)
      return (fs::path(output_).parent_path() / kept).string();
    if (errno != EEXIST) break;
  }
  const int error = errno;
  ::renameat2(staging.descriptor(), name_.c_str(), folder_.descriptor(), name_.c_str(), RENAME_EXCHANGE);
  errno = error;
  fail_by_errno(output_,
                "cannot move the files that were added to the previous result; the previous result is back in place");
}

void StagedResult::remove() const {
  if (const OpenFile staging = open_staging(); staging.is_open()) remove_own_folder(folder_, staging_, staging);
}

std::vector<std::string> sweep_staging(const PathRoots& roots, const std::vector<std::string>& folders,
                                       const std::string& instance,
                                       const std::function<bool(std::int64_t)>& is_finished_with) {
  std::vector<std::string> removed;
  const std::string prefix = prefix_of(instance);
  for (const std::string& path : folders) {
    try {
      const OpenFile folder = roots.open_folder_of(path + "/any");
      for (const std::string& name : names_in(folder, path)) {
        if (!name.starts_with(prefix)) continue;
        std::int64_t id = 0;
        const char* end = name.data() + name.size();
        const auto [stop, failed] = std::from_chars(name.data() + prefix.size(), end, id);
        if (failed != std::errc() || stop != end || !is_finished_with(id)) continue;
        if (remove_staging(folder, name, path + "/" + name)) removed.push_back(path + "/" + name);
      }
    } catch (const Error&) {  // no longer exists, or is not below a root
    }
  }
  return removed;
}

}  // namespace multum
