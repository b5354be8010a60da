// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "host/foundation/base/error.h"

namespace multum {

SharedMemory::SharedMemory() : is_owner_(true) {
  descriptor_ = ::memfd_create("multum", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (descriptor_ < 0) fail_by_errno("shared memory", "memfd_create");
  if (::fcntl(descriptor_, F_ADD_SEALS, F_SEAL_SHRINK) != 0) fail_by_errno("shared memory", "F_SEAL_SHRINK");
}

SharedMemory::SharedMemory(int descriptor) : descriptor_(descriptor) {}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) ::munmap(data_, byte_count_);
  if (is_owner_) ::close(descriptor_);
}

void SharedMemory::map(std::size_t byte_count) {
  void* data = ::mmap(nullptr, byte_count, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (data == MAP_FAILED) fail_by_errno("shared memory", "mmap");
  if (data_ != nullptr) ::munmap(data_, byte_count_);
  data_ = static_cast<std::byte*>(data);
  byte_count_ = byte_count;
}

std::byte* SharedMemory::reserve(std::size_t byte_count) {
  if (byte_count > byte_count_) {
    if (::ftruncate(descriptor_, static_cast<off_t>(byte_count)) != 0)
      throw Error(ErrorCode::kEnvironment, "shared memory of " + std::to_string(byte_count) +
                                               " bytes: " + std::strerror(errno) +
                                               (errno == EFBIG ? "; raise the limit of file sizes (ulimit -f)" : ""));
    map(byte_count);
  }
  return data_;
}

std::byte* SharedMemory::see(std::size_t& byte_count) {
  struct stat status = {};
  if (::fstat(descriptor_, &status) != 0) fail_by_errno("shared memory", "fstat");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > byte_count_) map(size);
  byte_count = byte_count_;
  return data_;
}

}  // namespace multum
