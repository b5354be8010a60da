// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/own_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr int kDepthMax = 64;    // the largest depth of nested folders, because every level keeps a file open
constexpr int kTriesMax = 1000;  // other processes can remove the folder between its creation and its opening
constexpr char kMark[] = ".multum-folder";
constexpr mode_t kOwnMode = 0700;  // no other user can list the folder, or put a link there
constexpr mode_t kOthersWrite = S_IWGRP | S_IWOTH;

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kEnvironment,
              fmt::format("{}: {}; expected a new folder, or one to which only this user can write. It was left "
                          "unchanged. Remove it, or write to another folder",
                          path, what));
}

[[noreturn]] void refuse_owner(const std::string& path, const struct stat& found) {
  refuse(path, fmt::format("belongs to user {}, but multum runs as user {}", found.st_uid, ::geteuid()));
}

const char* kind_of(mode_t mode) {
  if (S_ISLNK(mode)) return "is a symbolic link";
  if (S_ISREG(mode)) return "is a file";
  return S_ISDIR(mode) ? "is a folder" : "is neither a file nor a folder";
}

// Creates a file under a random name in the folder, and returns the system's data about it.
struct stat state_of_new_file(const OpenFile& folder) {
  struct stat made {};
  const std::string name = ".multum-probe-" + random_digits();
  const OpenFile probe(
      ::openat(folder.descriptor(), name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  made.st_uid = ::geteuid();
  if (!probe.is_open()) return made;
  ::unlinkat(folder.descriptor(), name.c_str(), 0);
  ::fstat(probe.descriptor(), &made);
  return made;
}

void check_is_own(const OpenFile& above, const OpenFile& folder, const std::string& path) {
  struct stat outside {
  }, found{};
  if (::fstat(above.descriptor(), &outside) != 0 || ::fstat(folder.descriptor(), &found) != 0)
    fail_by_errno(path, "cannot be examined");
  if (found.st_dev != outside.st_dev) refuse(path, "is the mount point of another file system");
  const auto is_own = [&](uid_t owner, mode_t ignored) {
    return found.st_uid == owner && (found.st_mode & kOthersWrite & ~ignored) == 0;
  };
  if (is_own(::geteuid(), 0)) return;
  const struct stat made = state_of_new_file(above);
  if (is_own(made.st_uid, made.st_mode)) return;
  if (found.st_uid != made.st_uid) refuse_owner(path, found);
  refuse(path, fmt::format("has the mode {:04o}, which lets other users write to it", found.st_mode & 07777U));
}

// If the name does not exist, the result is not open, and errno is ENOENT.
OpenFile open_if_own(const OpenFile& above, const std::string& name, const std::string& path) {
  OpenFile folder(::openat(above.descriptor(), name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (folder.is_open()) check_is_own(above, folder, path);
  if (folder.is_open() || errno == ENOENT) return folder;
  const int error = errno;
  struct stat found {};
  if (::fstatat(above.descriptor(), name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0) return OpenFile();
  if (!S_ISDIR(found.st_mode)) refuse(path, kind_of(found.st_mode));
  if (found.st_uid != ::geteuid()) refuse_owner(path, found);
  errno = error;
  fail_by_errno(path, "cannot be opened");
}

bool remove_all_in(int folder, dev_t device, const std::vector<std::string>& kept, int depth);

bool remove_one(int folder, dev_t device, const std::string& name, int depth) {
  if (::unlinkat(folder, name.c_str(), 0) == 0 || errno == ENOENT) return true;
  if (errno != EISDIR && errno != EPERM) return false;
  const OpenFile below(::openat(folder, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat found {};
  if (!below.is_open() || ::fstat(below.descriptor(), &found) != 0 || found.st_dev != device) return false;
  return remove_all_in(below.descriptor(), device, {}, depth + 1) &&
         ::unlinkat(folder, name.c_str(), AT_REMOVEDIR) == 0;
}

// Lists the names in an open folder. Returns false and sets errno if they cannot be read. Uses the descriptor itself,
// so a process that cannot open more files can still remove its own folder.
bool list_names(int folder, std::vector<std::string>& names) {
  if (::lseek(folder, 0, SEEK_SET) < 0) return false;
  alignas(dirent64) char entries[32 << 10];
  while (true) {
    const ssize_t bytes = ::getdents64(folder, entries, sizeof(entries));
    if (bytes <= 0) return bytes == 0;
    for (ssize_t at = 0; at < bytes;) {
      const auto* entry = reinterpret_cast<const dirent64*>(entries + at);
      const std::string name = entry->d_name;
      if (name != "." && name != "..") names.push_back(name);
      at += entry->d_reclen;
    }
  }
}

bool remove_all_in(int folder, dev_t device, const std::vector<std::string>& kept, int depth) {
  std::vector<std::string> names;
  if (depth > kDepthMax || !list_names(folder, names)) return false;
  bool is_all = true;
  for (const std::string& name : names)
    if (std::find(kept.begin(), kept.end(), name) == kept.end() && !remove_one(folder, device, name, depth))
      is_all = false;
  return is_all;
}

}  // namespace

void check_name_length(const std::string& path, const std::string& name) {
  if (name.size() > kOutputNameMax)
    throw Error(ErrorCode::kUsage, fmt::format("{}: its name has {} bytes, expected at most {}: choose a shorter name",
                                               path, name.size(), kOutputNameMax));
}

NamedPlace open_place(const std::string& path) {
  const fs::path whole(path);
  const std::string above = whole.has_parent_path() ? whole.parent_path().string() : ".";
  NamedPlace place{OpenFile(::open(above.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)), whole.filename().string()};
  // A folder can be writable even if it cannot be listed.
  if (!place.folder.is_open() && errno == EACCES)
    place.folder = OpenFile(::open(above.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!place.folder.is_open() && (errno == ENAMETOOLONG || errno == ELOOP))
    throw Error(ErrorCode::kUsage, fmt::format("{}: the name of its folder is too long, or its links form a circle; "
                                               "choose another folder",
                                               path));
  if (!place.folder.is_open() && errno == ENOENT)
    throw Error(ErrorCode::kEnvironment, path + ": the folder " + above + " does not exist");
  if (!place.folder.is_open()) fail_by_errno(path, "the folder " + above + " cannot be opened");
  return place;
}

OpenFile open_own_folder(const OpenFile& above, const std::string& name, const std::string& path) {
  for (int i = 0; i < kTriesMax; ++i) {
    const bool is_made = ::mkdirat(above.descriptor(), name.c_str(), kOwnMode) == 0;
    if (!is_made && errno == ENAMETOOLONG)
      throw Error(ErrorCode::kUsage, path + ": the name is too long for the file system; choose a shorter one");
    if (!is_made && errno != EEXIST) fail_by_errno(path, "cannot be created");
    try {
      if (OpenFile folder = open_if_own(above, name, path); folder.is_open()) return folder;
    } catch (...) {
      if (is_made) ::unlinkat(above.descriptor(), name.c_str(), AT_REMOVEDIR);
      throw;
    }
  }
  refuse(path, "another process removes it repeatedly");
}

bool mark_own_folder(const OpenFile& folder, const std::string& path) {
  if (::faccessat(folder.descriptor(), kMark, F_OK, AT_SYMLINK_NOFOLLOW) == 0) return true;
  const std::vector<std::string> names = names_in(folder, path);
  if (!names.empty() && names.front() != kMark)
    refuse(path, fmt::format("holds '{}' but no {}, so multum did not create it", names.front(), kMark));
  const OpenFile mark(::openat(folder.descriptor(), kMark, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!mark.is_open() && errno == ENOENT) return false;
  if (!mark.is_open() && errno != EEXIST) fail_by_errno(path, "cannot create a file in it");
  return true;
}

OpenFile find_own_folder(const OpenFile& above, const std::string& name, const std::string& path) {
  OpenFile folder = open_if_own(above, name, path);
  if (folder.is_open() && !mark_own_folder(folder, path)) return OpenFile();
  return folder;
}

bool clear_own_folder(const OpenFile& folder, const std::string& kept) {
  struct stat found {};
  return ::fstat(folder.descriptor(), &found) == 0 &&
         remove_all_in(folder.descriptor(), found.st_dev, {kMark, kept}, 0);
}

bool remove_own_folder(const OpenFile& above, const std::string& name, const OpenFile& folder) {
  // The mark is removed last. If the process is killed before that, the remaining folder is still marked, or empty.
  if (!clear_own_folder(folder)) return false;
  ::unlinkat(folder.descriptor(), kMark, 0);
  return !is_named(above, name, folder.descriptor()) || ::unlinkat(above.descriptor(), name.c_str(), AT_REMOVEDIR) == 0;
}

bool is_named(const OpenFile& folder, const std::string& name, int descriptor) {
  struct stat named {
  }, opened{};
  return ::fstatat(folder.descriptor(), name.c_str(), &named, AT_SYMLINK_NOFOLLOW) == 0 &&
         ::fstat(descriptor, &opened) == 0 && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev;
}

std::vector<std::string> names_in(const OpenFile& folder, const std::string& path) {
  std::vector<std::string> names;
  if (!list_names(folder.descriptor(), names)) fail_by_errno(path, "cannot be listed");
  return names;
}

bool remove_entry(const OpenFile& folder, const std::string& name) {
  struct stat found {};
  return ::fstat(folder.descriptor(), &found) == 0 && remove_one(folder.descriptor(), found.st_dev, name, 0);
}

std::string random_digits() {
  std::uint64_t bits = 0;
  if (::getrandom(&bits, sizeof(bits), 0) != static_cast<ssize_t>(sizeof(bits)))
    fail_by_errno("getrandom", "the system provides no random numbers");
  return fmt::format("{:016x}", bits);
}

}  // namespace multum
