// SPDX-License-Identifier: Apache-2.0
#include "host/service/result_listing.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>
#include <sstream>
#include <vector>

#include "host/base/atomic_file.h"
#include "host/base/error.h"
#include "host/base/open_file.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kListing[] = ".multum-result";
constexpr off_t kListingMax = 64 << 20;  // bytes

// "BYTES NANOSECONDS" by name, of all that is no folder; a name with a line's end is none of ours.
std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    struct stat found {};
    if (::lstat(entry->path().c_str(), &found) != 0 || S_ISDIR(found.st_mode)) continue;
    files[entry->path().lexically_relative(folder).string()] =
        fmt::format("{} {}", found.st_size, found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec);
  }
  if (error)
    throw Error(ErrorCode::kEnvironment, fmt::format("{}: cannot be listed: {}", folder.string(), error.message()));
  files.erase(kListing);
  return files;
}

std::map<std::string, std::string> listed_in(const fs::path& folder) {
  std::map<std::string, std::string> files;
  // A pipe, a link or a file without end is no listing.
  const OpenFile file(::open((folder / kListing).c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  // Nor is one that cannot be read for now the same as none.
  if (!file.is_open() && errno != ENOENT && errno != ENOTDIR && errno != ELOOP)
    fail_by_errno((folder / kListing).string(), "cannot be read");
  struct stat found {};
  if (!file.is_open() || ::fstat(file.descriptor(), &found) != 0 || !S_ISREG(found.st_mode) ||
      found.st_size > kListingMax)
    return files;
  std::string text(static_cast<std::size_t>(found.st_size), '\0');
  const ssize_t count = ::pread(file.descriptor(), text.data(), text.size(), 0);
  if (count < 0) fail_by_errno((folder / kListing).string(), "cannot be read");
  text.resize(static_cast<std::size_t>(count));
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (second != std::string::npos) files[line.substr(second + 1)] = line.substr(0, second);
  }
  return files;
}

}  // namespace

void write_result_listing(const std::string& folder) {
  std::string text;
  for (const auto& [name, state] : files_in(folder)) text += fmt::format("{} {}\n", state, name);
  write_text_file(folder + "/" + kListing, text);
}

std::string unlisted_in(const std::string& folder) {
  const std::map<std::string, std::string> listed = listed_in(folder);
  for (const auto& [name, state] : files_in(folder)) {
    const auto found = listed.find(name);
    if (found == listed.end() || found->second != state) return name;
  }
  return "";
}

bool remove_listed(const std::string& folder) {
  const std::map<std::string, std::string> listed = listed_in(folder);
  std::error_code error;
  bool is_all = true;
  for (const auto& [name, state] : files_in(folder)) {
    const auto found = listed.find(name);
    if (found != listed.end() && found->second == state) fs::remove(fs::path(folder) / name, error);
    else is_all = false;
  }
  if (is_all) fs::remove(fs::path(folder) / kListing, error);
  // Deepest first; those that hold something stay.
  std::vector<fs::path> folders = {folder};
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->is_directory(error) && !entry->is_symlink(error)) folders.push_back(entry->path());
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) { return a > b; });
  for (const fs::path& one : folders) fs::remove(one, error);
  return is_all;
}

}  // namespace multum
