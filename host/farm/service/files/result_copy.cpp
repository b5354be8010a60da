// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/result_copy.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <vector>

#include "host/farm/service/files/result_listing.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCopyPiece = 1 << 20;  // bytes copied at once
constexpr int kCopyDepthMax = 32;            // nested folders, each of which takes two open files

// An entry of an open folder. Messages show `path`.
struct Place {
  int folder;
  std::string name, path;
};

void sync(const OpenFile& file, const std::string& path) {
  if (::fsync(file.descriptor()) != 0) fail_by_errno(path, "cannot be synced");
}

void write_all(const OpenFile& file, const char* bytes, std::size_t count, const std::string& path) {
  while (count > 0) {
    const ssize_t written = ::write(file.descriptor(), bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail_by_errno(path, "cannot be written");
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
}

void copy_file(const OpenFile& from, mode_t mode, const Place& source, const Place& target) {
  const OpenFile to(
      ::openat(target.folder, target.name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode & 0777));
  if (!to.is_open()) fail_by_errno(target.path, "cannot be written");
  std::vector<char> piece(kCopyPiece);
  for (;;) {
    const ssize_t count = ::read(from.descriptor(), piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail_by_errno(source.path, "cannot be read");
    if (count == 0) break;
    write_all(to, piece.data(), static_cast<std::size_t>(count), target.path);
  }
  sync(to, target.path);
}

void copy_entry(const Place& source, const Place& target, int depth) {
  const OpenFile from(::openat(source.folder, source.name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat found {};
  if (!from.is_open() || ::fstat(from.descriptor(), &found) != 0) fail_by_errno(source.path, "cannot be copied");
  if (S_ISREG(found.st_mode)) return copy_file(from, found.st_mode, source, target);
  if (!S_ISDIR(found.st_mode) || depth == kCopyDepthMax)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: cannot be copied; expected a file, or folders that are nested at most {} levels deep",
                            source.path, kCopyDepthMax));
  if (::mkdirat(target.folder, target.name.c_str(), found.st_mode & 0777) != 0)
    fail_by_errno(target.path, "cannot be created");
  const OpenFile to(::openat(target.folder, target.name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!to.is_open()) fail_by_errno(target.path, "cannot be opened");
  for (const std::string& name : names_in(from, source.path))
    if (depth > 0 || name != kResultListingName)  // the copy gets a listing of its own
      copy_entry({from.descriptor(), name, source.path + "/" + name}, {to.descriptor(), name, target.path + "/" + name},
                 depth + 1);
  sync(to, target.path);
}

}  // namespace

void copy_result(const PathRoots& roots, const std::string& from, const std::string& to) {
  const OpenFile source = roots.open_folder_of(from), target = roots.open_folder_of(to);
  const std::string name = fs::path(to).filename().string();
  remove_entry(target, name);  // remains of an earlier attempt
  copy_entry({source.descriptor(), fs::path(from).filename().string(), from}, {target.descriptor(), name, to}, 0);
  sync(target, to);
}

}  // namespace multum
