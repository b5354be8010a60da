// SPDX-License-Identifier: Apache-2.0
#include "host/service/path_roots.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "host/base/error.h"

namespace multum {

namespace fs = std::filesystem;

PathRoots::PathRoots(const std::vector<std::string>& roots) {
  for (const std::string& root : roots) {
    std::error_code error;
    const fs::path canonical = fs::canonical(root, error);
    if (error || !fs::is_directory(canonical, error))
      throw Error(ErrorCode::kUsage, fmt::format("root '{}' is no folder", root));
    roots_.push_back(canonical.string());
  }
}

void PathRoots::refuse(const std::string& path) const {
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: is not below a folder that this service may use: {}", path, fmt::join(roots_, ", ")));
}

bool PathRoots::is_inside(const std::string& canonical) const {
  return std::any_of(roots_.begin(), roots_.end(), [&](const std::string& root) {
    return root == "/" ||
           (canonical.starts_with(root) && canonical.size() > root.size() && canonical[root.size()] == '/');
  });
}

std::string PathRoots::input(const std::string& path) const {
  if (!path.starts_with('/')) throw Error(ErrorCode::kUsage, fmt::format("'{}': expected an absolute path", path));
  std::error_code error;
  const fs::path canonical = fs::canonical(path, error);
  // What is outside is refused by its name first: whether it is there is nobody's business.
  if (error) {
    if (!is_inside(fs::weakly_canonical(path, error).string())) refuse(path);
    throw Error(ErrorCode::kUsage, fmt::format("{}: there is no such file", path));
  }
  if (!is_inside(canonical.string())) refuse(path);
  if (!fs::is_regular_file(canonical, error)) throw Error(ErrorCode::kUsage, fmt::format("{}: is no file", path));
  return canonical.string();
}

std::string PathRoots::output(const std::string& path) const {
  if (!path.starts_with('/')) throw Error(ErrorCode::kUsage, fmt::format("'{}': expected an absolute path", path));
  const fs::path named = fs::path(path).lexically_normal();
  const std::string name = named.filename().string();
  if (name.empty() || name == ".." || name.starts_with(".multum-"))
    throw Error(ErrorCode::kUsage, fmt::format("{}: is no name for a result", path));
  std::error_code error;
  const fs::path folder = fs::canonical(named.parent_path(), error);
  if (error) {
    if (!is_inside(fs::weakly_canonical(named, error).string())) refuse(path);
    throw Error(ErrorCode::kUsage, fmt::format("{}: its folder is not there", path));
  }
  const fs::path result = folder / name;
  if (!is_inside(result.string())) refuse(path);
  const fs::file_status status = fs::symlink_status(result, error);
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    throw Error(ErrorCode::kUsage, fmt::format("{}: is there already, and neither file nor folder", path));
  return result.string();
}

}  // namespace multum
