// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/work_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>
#include <vector>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kWorkPrefix[] = ".multum-work-";

enum class Lock { kTaken, kOurs, kUnsupported };

// Some network file systems do not support locks. There, work continues, but folders that remain after a run was killed
// are not removed.
Lock work_lock(const OpenFile& folder, const std::string& path) {
  while (::flock(folder.descriptor(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return Lock::kTaken;
    if (errno == ENOLCK || errno == EOPNOTSUPP || errno == ENOSYS || errno == EINVAL) return Lock::kUnsupported;
    if (errno != EINTR) fail_by_errno(path, "cannot be locked");
  }
  return Lock::kOurs;
}

}  // namespace

std::unique_ptr<WorkFolder> WorkFolder::take(const std::string& path) {
  while (true) {
    NamedPlace place = open_place(path);
    OpenFile folder = open_own_folder(place.folder, place.name, path);
    if (work_lock(folder, path) == Lock::kTaken) return nullptr;
    // The previous owner can remove the folder after this process has opened it and before this process locks it.
    if (!is_named(place.folder, place.name, folder.descriptor())) continue;
    try {
      if (mark_own_folder(folder, path))
        return std::unique_ptr<WorkFolder>(new WorkFolder(std::move(place), std::move(folder), path));
    } catch (...) {
      ::unlinkat(place.folder.descriptor(), place.name.c_str(), AT_REMOVEDIR);  // removes it only if it is empty
      throw;
    }
  }
}

std::unique_ptr<WorkFolder> WorkFolder::make(const std::string& folder) {
  const fs::path above = folder.empty() ? "." : folder;
  sweep(above.string());
  while (true)  // the sweep of another process may have locked it first
    if (auto made = take((above / (kWorkPrefix + random_digits())).string())) return made;
}

// Removes the folders of runs that were killed. Such folders are not locked by any process.
void WorkFolder::sweep(const std::string& folder) {
  std::error_code ignored;
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(kWorkPrefix)) found.push_back(entry.path().string());
  for (const std::string& path : found) drop(path);
}

void WorkFolder::drop(const std::string& path) {
  try {
    const NamedPlace place = open_place(path);
    const OpenFile folder = find_own_folder(place.folder, place.name, path);
    if (folder.is_open() && work_lock(folder, path) == Lock::kOurs &&
        is_named(place.folder, place.name, folder.descriptor()))
      remove_own_folder(place.folder, place.name, folder);
  } catch (const Error&) {  // the folder is not an own folder, so it stays
  }
}

WorkFolder::WorkFolder(NamedPlace place, OpenFile folder, std::string shown_path)
    : place_(std::move(place)),
      folder_(std::move(folder)),
      path_(fmt::format("/proc/{}/fd/{}", ::getpid(), folder_.descriptor())),
      shown_path_(std::move(shown_path)) {}

WorkFolder::~WorkFolder() {
  // A child of fork() has a copy of this object. The folder stays, because it belongs to the process that made it.
  const bool is_owner = path_.starts_with(fmt::format("/proc/{}/", ::getpid()));
  if (!stays_ && is_owner) remove_own_folder(place_.folder, place_.name, folder_);
}

void WorkFolder::clear(const std::string& kept) const {
  if (!clear_own_folder(folder_, kept)) fail_by_errno(shown_path_, "a part of interrupted work cannot be removed");
}

std::string partial_folder_of(const std::string& output) {
  const fs::path path(output);
  const fs::path above = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return (above / (".multum-partial-" + path.filename().string())).string();
}

}  // namespace multum
