// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/scratch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/system_failure.h"

namespace multum {

ScratchFile::ScratchFile(std::string folder) : folder_(folder.empty() ? "." : std::move(folder)) {
  std::string name = folder_ + "/.multum-scratch-XXXXXX";
  descriptor_ = mkostemp(name.data(), O_CLOEXEC);
  if (descriptor_ < 0)
    throw Error(ErrorCode::kEnvironment, folder_ + ": cannot create a scratch file there: " + errno_text(errno));
  unlink(name.c_str());
}

ScratchFile::ScratchFile(const WorkFolder& folder, const std::string& name) : folder_(folder.shown_path()) {
  descriptor_ = openat(folder.descriptor(), name.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
  if (descriptor_ < 0) fail_by_errno(folder_ + "/" + name, "cannot be opened");
}

ScratchFile::ScratchFile(std::string folder, const std::string& name) : folder_(std::move(folder)) {
  const std::string path = folder_ + "/" + name;
  descriptor_ = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
  if (descriptor_ < 0) fail_by_errno(path, "cannot be opened");
}

ScratchFile ScratchFile::to_read(const std::string& path) {
  ScratchFile file;
  file.folder_ = path;
  file.descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file.descriptor_ < 0) throw Error(ErrorCode::kEnvironment, path + ": cannot be opened: " + errno_text(errno));
  return file;
}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : folder_(std::move(other.folder_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

ScratchFile& ScratchFile::operator=(ScratchFile&& other) noexcept {
  std::swap(folder_, other.folder_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

void ScratchFile::write(std::uint64_t offset, const void* data, std::size_t byte_count) {
  const char* from = static_cast<const char*>(data);
  while (byte_count > 0) {
    const ssize_t written = pwrite(descriptor_, from, byte_count, static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      throw Error(ErrorCode::kEnvironment, folder_ + ": cannot write a scratch file there: " + errno_text(errno));
    from += written;
    offset += static_cast<std::uint64_t>(written);
    byte_count -= static_cast<std::size_t>(written);
  }
}

void ScratchFile::read(std::uint64_t offset, void* data, std::size_t byte_count) const {
  char* to = static_cast<char*>(data);
  while (byte_count > 0) {
    const ssize_t got = pread(descriptor_, to, byte_count, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      throw Error(ErrorCode::kEnvironment,
                  folder_ + ": cannot read a scratch file there: " +
                      (got < 0 ? errno_text(errno) : "it ends before the end of the written data"));
    to += got;
    offset += static_cast<std::uint64_t>(got);
    byte_count -= static_cast<std::size_t>(got);
  }
}

}  // namespace multum
