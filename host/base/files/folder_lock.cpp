// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "host/base/error.h"

namespace multum {
namespace {

// The process that had the folder may have removed it between our opening and our locking it.
bool is_still_there(const std::string& path, int descriptor) {
  struct stat named {
  }, opened{};
  return stat(path.c_str(), &named) == 0 && fstat(descriptor, &opened) == 0 && named.st_ino == opened.st_ino;
}

}  // namespace

std::unique_ptr<FolderLock> FolderLock::take(const std::string& path) {
  while (true) {
    if (mkdir(path.c_str(), 0777) != 0 && errno != EEXIST) fail_by_errno(path, "cannot be made");
    const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0 && errno == ENOENT) continue;
    if (descriptor < 0) fail_by_errno(path, "cannot be made");
    std::unique_ptr<FolderLock> lock(new FolderLock(descriptor));
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0) return nullptr;
    if (is_still_there(path, descriptor)) return lock;
  }
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace multum
