// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/upload_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "host/farm/service/files/no_space.h"

namespace multum {

UploadFile::UploadFile(const std::string& folder)
    : folder_(folder), file_(::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600)) {
  if (!file_.is_open()) fail_to_write(folder, "an upload cannot be stored here");
}

void UploadFile::write(std::string_view bytes) {
  hash_.update(bytes);
  bytes_ += static_cast<std::int64_t>(bytes.size());
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_.descriptor(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail_to_write(folder_, "an upload cannot be stored here");
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

void UploadFile::name(const std::string& path) {
  if (::fchmod(file_.descriptor(), 0440) != 0 || ::fsync(file_.descriptor()) != 0)
    fail_to_write(path, "cannot be synced");
  // Makes the link through /proc, because only privileged processes may link a descriptor directly.
  const std::string own = "/proc/self/fd/" + std::to_string(file_.descriptor());
  if (::linkat(AT_FDCWD, own.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) != 0 && errno != EEXIST)
    fail_to_write(path, "cannot be created under its final name");
  const OpenFile folder(::open(std::filesystem::path(path).parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open() || ::fsync(folder.descriptor()) != 0) fail_to_write(path, "its folder cannot be synced");
}

}  // namespace multum
