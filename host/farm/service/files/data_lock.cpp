// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/data_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

bool is_of_us_or_root(const struct stat& found) { return found.st_uid == ::geteuid() || found.st_uid == 0; }

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kEnvironment, fmt::format("{}: {}; expected a folder to which only the daemon's user can "
                                                   "write. Choose another folder, or change its owner and mode",
                                                   path, what));
}

// Follows a symbolic link that this user or root made. Returns other paths unchanged.
std::string resolved(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 || !S_ISLNK(found.st_mode)) return path;
  if (!is_of_us_or_root(found)) refuse(path, fmt::format("is a link that user {} made", found.st_uid));
  std::error_code error;
  const std::string target = std::filesystem::canonical(path, error).string();
  if (error) refuse(path, "is a link to a missing file");
  return target;
}

// If root owns the folder, its group may have write permission, because volumes of containers have such permissions.
void check_owner(const OpenFile& folder, const std::string& path) {
  struct stat found {};
  if (::fstat(folder.descriptor(), &found) != 0) fail_by_errno(path, "cannot be examined");
  if (!is_of_us_or_root(found))
    refuse(path, fmt::format("belongs to user {}, but multum runs as user {}", found.st_uid, ::geteuid()));
  const bool is_volume = found.st_uid == 0 && ::geteuid() != 0;
  if ((found.st_mode & (is_volume ? S_IWOTH : S_IWGRP | S_IWOTH)) != 0)
    refuse(path, fmt::format("has the mode {:04o}, which lets other users write to it", found.st_mode & 07777U));
}

}  // namespace

std::unique_ptr<DataLock> DataLock::take(const std::string& path) {
  while (true) {
    const std::string folder = resolved(path);
    if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) fail_by_errno(path, "cannot be created");
    OpenFile opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!opened.is_open() && (errno == ENOENT || errno == ELOOP)) continue;  // removed, or replaced by a link
    if (!opened.is_open()) fail_by_errno(path, "cannot be opened");
    check_owner(opened, path);
    if (::flock(opened.descriptor(), LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) return nullptr;
      fail_by_errno(path, "cannot be locked");
    }
    struct stat named {
    }, held{};
    if (::stat(folder.c_str(), &named) == 0 && ::fstat(opened.descriptor(), &held) == 0 &&
        named.st_ino == held.st_ino && named.st_dev == held.st_dev)
      return std::unique_ptr<DataLock>(new DataLock(std::move(opened)));
  }
}

}  // namespace multum
