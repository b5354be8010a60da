// SPDX-License-Identifier: Apache-2.0
// This LD_PRELOAD library for fault_injection/failed_calls.py lets one of the system calls fail with which a daemon
// writes files. The file that MULTUM_FAULTS names is memory that is shared with the test:
//   [0] number of the call to fail, from 1; 0 for none   [1] its errno   [2] calls so far   [3] failed calls
// Workers load the library too, but no call fails in them: fault_injection/kills.py tests how workers end.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace {

struct Orders {
  std::atomic<std::int64_t> failing, error, count, failed;
};

bool is_daemon() {
  char line[4096] = {};
  const int file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, "/proc/self/cmdline", O_RDONLY));
  const ssize_t size = file < 0 ? 0 : ::read(file, line, sizeof(line) - 1);
  if (file >= 0) ::close(file);
  return size > 0 && std::strcmp(line + std::strlen(line) + 1, "serve") == 0;
}

Orders* orders() {
  static Orders* const shared = []() -> Orders* {
    const char* path = std::getenv("MULTUM_FAULTS");
    if (path == nullptr || !is_daemon()) return nullptr;
    const int file = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC));
    if (file < 0) return nullptr;
    void* const memory = ::mmap(nullptr, sizeof(Orders), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    return memory == MAP_FAILED ? nullptr : static_cast<Orders*>(memory);
  }();
  return shared;
}

bool fails() {
  Orders* const o = orders();
  if (o == nullptr || o->failing == 0 || ++o->count != o->failing) return false;
  ++o->failed;
  errno = static_cast<int>(o->error);
  return true;
}

// Only calls that may create files have a mode argument.
int open_with(int folder, const char* path, int flags, std::va_list list) {
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  return fails() ? -1 : static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
}

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int open64(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const int file = open_with(AT_FDCWD, path, flags, list);
  va_end(list);
  return file;
}
int open(const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const int file = open_with(AT_FDCWD, path, flags, list);
  va_end(list);
  return file;
}
int openat(int folder, const char* path, int flags, ...) {
  std::va_list list;
  va_start(list, flags);
  const int file = open_with(folder, path, flags, list);
  va_end(list);
  return file;
}
// Intercepts openat2, which has no libc function. Other system calls, such as those of Landlock, pass through.
long syscall(long number, ...) {
  long a[6];
  va_list list;
  va_start(list, number);
  for (long& one : a) one = va_arg(list, long);
  va_end(list);
  if (number == SYS_openat2 && fails()) return -1;
  static const auto real = next<long(long, ...)>("syscall");
  return real(number, a[0], a[1], a[2], a[3], a[4], a[5]);
}
int fsync(int file) { return fails() ? -1 : next<int(int)>("fsync")(file); }
int fdatasync(int file) { return fails() ? -1 : next<int(int)>("fdatasync")(file); }
int renameat2(int from, const char* a, int to, const char* b, unsigned flags) {
  return fails() ? -1 : next<int(int, const char*, int, const char*, unsigned)>("renameat2")(from, a, to, b, flags);
}
int rename(const char* a, const char* b) { return fails() ? -1 : next<int(const char*, const char*)>("rename")(a, b); }
int unlink(const char* path) { return fails() ? -1 : next<int(const char*)>("unlink")(path); }
int unlinkat(int folder, const char* path, int flags) {
  return fails() ? -1 : next<int(int, const char*, int)>("unlinkat")(folder, path, flags);
}
int mkdir(const char* path, mode_t mode) { return fails() ? -1 : next<int(const char*, mode_t)>("mkdir")(path, mode); }
int ftruncate64(int file, off64_t size) { return fails() ? -1 : next<int(int, off64_t)>("ftruncate64")(file, size); }
ssize_t pwrite64(int file, const void* data, size_t size, off64_t at) {
  return fails() ? -1 : next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(file, data, size, at);
}

}  // extern "C"
