// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/windows/posix_calls.h"

#include <io.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

int fcntl(int descriptor, int command, int) { return command == F_DUPFD_CLOEXEC ? ::_dup(descriptor) : 0; }

ssize_t pread(int descriptor, void* memory, std::size_t byte_count, off_t position) {
  const auto handle = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
  if (handle == INVALID_HANDLE_VALUE) {
    errno = EBADF;
    return -1;
  }
  // ReadFile() takes the position from this structure, so no other thread can move it in between.
  OVERLAPPED where = {};
  where.Offset = static_cast<DWORD>(position);
  where.OffsetHigh = static_cast<DWORD>(static_cast<std::uint64_t>(position) >> 32);
  constexpr std::size_t kLargestRead = std::size_t{1} << 30;
  DWORD done = 0;
  if (::ReadFile(handle, memory, static_cast<DWORD>(std::min(byte_count, kLargestRead)), &done, &where) != 0 ||
      ::GetLastError() == ERROR_HANDLE_EOF)
    return static_cast<ssize_t>(done);
  errno = EIO;
  return -1;
}

ssize_t readlink(const char*, char*, std::size_t) {
  errno = ENOSYS;
  return -1;
}

int setenv(const char* name, const char* value, int replace) {
  return replace == 0 && std::getenv(name) != nullptr ? 0 : ::_putenv_s(name, value);
}

int sigaction(int number, const struct sigaction* action, struct sigaction* former) {
  void (*const handler)(int) = action == nullptr ? SIG_GET : action->sa_handler;
  void (*const found)(int) = std::signal(number, handler);
  if (found == SIG_ERR) return -1;
  if (former != nullptr) former->sa_handler = found;
  return 0;
}
