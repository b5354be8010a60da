// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/helper_service.h"

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "host/foundation/base/error.h"
#include "host/foundation/sandbox/read_only_process.h"

namespace multum {
namespace {

// Ends the child together with its parent, even during a library call that never returns.
void end_with_asker() {
  for (;;) {
    pollfd waited = {kHelperSocket, POLLRDHUP, 0};
    if (::poll(&waited, 1, -1) > 0) std::_Exit(0);
  }
}

bool receive(char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t got = ::recv(kHelperSocket, bytes, count, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

bool send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(kHelperSocket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

// Disables core files, and limits the size of the output of libraries.
void limit_files() {
  const rlimit none = {0, 0}, little = {1 << 20, 1 << 20};
  ::setrlimit(RLIMIT_CORE, &none);
  ::setrlimit(RLIMIT_FSIZE, &little);
  ::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

int serve_helper(const std::function<std::string(std::string_view request, SharedMemory& memory)>& answer) {
  struct stat status = {};
  if (::fstat(kHelperSocket, &status) != 0 || !S_ISSOCK(status.st_mode)) return 2;
  limit_files();
  if (can_confine_to_reading() && !confine_to_reading())
    throw Error(ErrorCode::kEnvironment, "this process, which reads files for multum, cannot be confined");
  std::thread(end_with_asker).detach();
  SharedMemory memory(kHelperMemory);
  std::string request;
  for (std::uint64_t size = 0; receive(reinterpret_cast<char*>(&size), sizeof(size));) {
    request.resize(size);
    if (!receive(request.data(), request.size())) break;
    const std::string text = answer(request, memory);
    size = text.size();
    if (!send({reinterpret_cast<const char*>(&size), sizeof(size)}) || !send(text)) break;
  }
  std::_Exit(0);  // skips destructors, because a library may have corrupted its state
}

}  // namespace multum
