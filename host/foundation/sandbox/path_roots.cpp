// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/path_roots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <iterator>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/own_folder.h"

namespace multum {

namespace fs = std::filesystem;

namespace {

// glibc 2.36 has no function openat2(). Names with links fail here, because links were resolved when the path was
// checked.
int open_below(int root, const std::string& relative, int flags) {
  open_how how{};
  how.flags = static_cast<std::uint64_t>(flags | O_CLOEXEC | O_NOFOLLOW);
  how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
  return static_cast<int>(::syscall(SYS_openat2, root, relative.c_str(), &how, sizeof(how)));
}

bool is_below(const std::string& path, const std::string& folder) {
  return path.starts_with(folder) && path.size() > folder.size() && path[folder.size()] == '/';
}

// Resolves a name that does not exist: the part of it that exists, and links whose targets are missing. Otherwise a
// link in a root would reveal which files exist outside the root.
fs::path place_of(const fs::path& path) {
  constexpr int kLinksMax = 40;  // as many as the system allows
  fs::path place = "/", rest = path;
  std::error_code error;
  for (int links = 0; !rest.empty();) {
    const fs::path name = *rest.begin();
    fs::path after;
    for (auto part = std::next(rest.begin()); part != rest.end(); ++part) after /= *part;
    rest = after;
    if (name == "/" || name == "." || name.empty()) continue;
    if (name == "..") {
      place = place.parent_path();
      continue;
    }
    const fs::path target = links < kLinksMax ? fs::read_symlink(place / name, error) : fs::path();
    if (target.empty() || error) {
      place /= name;
      continue;
    }
    ++links;
    if (target.is_absolute()) place = "/";
    rest = target.relative_path() / rest;
  }
  return place;
}

bool is_same_folder(int descriptor, const std::string& path) {
  struct stat held {
  }, named{};
  return ::fstat(descriptor, &held) == 0 && ::stat(path.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
         held.st_ino == named.st_ino;
}

}  // namespace

OpenFile open_beneath_folder(const OpenFile& folder, const std::string& relative, int flags) {
  return OpenFile(open_below(folder.descriptor(), relative, flags));
}

PathRoots::PathRoots(const std::vector<std::string>& roots) {
  for (const std::string& root : roots) {
    std::error_code error;
    const fs::path canonical = fs::canonical(root, error);
    if (error || !fs::is_directory(canonical, error))
      throw Error(ErrorCode::kUsage, fmt::format("root '{}' is not a folder", root));
    OpenFile folder(::open(canonical.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder.is_open()) throw Error(ErrorCode::kUsage, fmt::format("root '{}' cannot be opened", root));
    if (const OpenFile itself(open_below(folder.descriptor(), ".", O_PATH)); !itself.is_open())
      fail_by_errno(root, "the system cannot open files beneath a folder (openat2, Linux 5.6 and later)");
    roots_.push_back(canonical.string());
    descriptors_.push_back(std::make_shared<const OpenFile>(std::move(folder)));
  }
}

OpenFile PathRoots::open_beneath(const std::string& canonical, int flags) const {
  // Chooses the deepest root, because roots can be nested.
  std::size_t best = roots_.size();
  for (std::size_t i = 0; i < roots_.size(); ++i)
    if ((canonical == roots_[i] || is_below(canonical, roots_[i])) &&
        (best == roots_.size() || roots_[i].size() > roots_[best].size()))
      best = i;
  if (best == roots_.size()) refuse(canonical);
  const std::string& root = roots_[best];
  const int descriptor = descriptors_[best]->descriptor();
  if (!is_same_folder(descriptor, root))
    throw Error(ErrorCode::kEnvironment, fmt::format("{}: its root {} was replaced or unmounted; restart the service "
                                                     "to use the new folder",
                                                     canonical, root));
  const std::string relative = canonical == root ? "." : canonical.substr(root.size() + 1);
  OpenFile file(open_below(descriptor, relative, flags));
  if (!file.is_open() && (errno == ELOOP || errno == EXDEV))
    throw Error(ErrorCode::kUsage, fmt::format("{}: has become a link, or its path contains a link", canonical));
  if (!file.is_open() && (errno == ENOENT || errno == ENOTDIR))
    throw Error(ErrorCode::kUsage, fmt::format("{}: no longer exists", canonical));
  if (!file.is_open()) fail_by_errno(canonical, "cannot be opened");
  return file;
}

OpenFile PathRoots::open_input(const std::string& canonical) const {
  OpenFile file = open_beneath(canonical, O_RDONLY | O_NONBLOCK);  // does not wait for a pipe
  struct stat found {};
  if (::fstat(file.descriptor(), &found) != 0 || !S_ISREG(found.st_mode))
    throw Error(ErrorCode::kUsage, fmt::format("{}: is not a file", canonical));
  return file;
}

OpenFile PathRoots::open_folder_of(const std::string& canonical) const {
  return open_beneath(fs::path(canonical).parent_path().string(), O_RDONLY | O_DIRECTORY);
}

void PathRoots::refuse(const std::string& path) const {
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: is not below a folder that this service may use: {}", path, fmt::join(roots_, ", ")));
}

bool PathRoots::is_inside(const std::string& canonical) const {
  return std::any_of(roots_.begin(), roots_.end(), [&](const std::string& root) { return is_below(canonical, root); });
}

std::string PathRoots::input(const std::string& path) const {
  if (!path.starts_with('/'))
    throw Error(ErrorCode::kUsage, fmt::format("'{}': expected the absolute path of a file below {}, or the path "
                                               "that the service returned for an upload",
                                               path, fmt::join(roots_, ", ")));
  std::error_code error;
  const fs::path canonical = fs::canonical(path, error);
  // Names outside the roots are rejected first, so that the answer does not reveal whether they exist.
  if (error) {
    if (!is_inside(place_of(path).string())) refuse(path);
    throw Error(ErrorCode::kUsage, fmt::format("{}: there is no such file", path));
  }
  if (!is_inside(canonical.string())) refuse(path);
  if (!fs::is_regular_file(canonical, error)) throw Error(ErrorCode::kUsage, fmt::format("{}: is not a file", path));
  return canonical.string();
}

std::string PathRoots::output(const std::string& path) const {
  if (!path.starts_with('/')) throw Error(ErrorCode::kUsage, fmt::format("'{}': expected an absolute path", path));
  const fs::path named = fs::path(path).lexically_normal();
  const std::string name = named.filename().string();
  if (name.empty() || name == ".." || name.starts_with(".multum-"))
    throw Error(ErrorCode::kUsage, fmt::format("{}: is not a valid name for a result", path));
  check_name_length(path, name);
  std::error_code error;
  const fs::path folder = fs::canonical(named.parent_path(), error);
  if (error) {
    if (!is_inside(place_of(named).string())) refuse(path);
    throw Error(ErrorCode::kUsage, fmt::format("{}: its folder does not exist", path));
  }
  const fs::path result = folder / name;
  if (!is_inside(result.string())) refuse(path);
  if (!fs::is_directory(folder, error))
    throw Error(ErrorCode::kUsage, fmt::format("{}: {} is not a folder", path, folder.string()));
  const fs::file_status status = fs::symlink_status(result, error);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    throw Error(ErrorCode::kUsage, fmt::format("{}: exists already and is neither a file nor a folder", path));
  return result.string();
}

}  // namespace multum
