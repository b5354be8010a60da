// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/driver_faults.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The message is prepared in advance, because no memory can safely be allocated after a fault.
std::array<char, 300> g_message;
size_t g_message_size = 0;

void on_fault(int) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, g_message.data(), g_message_size);
  ::_exit(exit_code(ErrorCode::kEnvironment));
}

}  // namespace

void explain_driver_faults() {
  rlimit limit = {};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  const auto end = fmt::format_to_n(g_message.data(), g_message.size(),
                                    "multum-view: the OpenGL driver failed, most likely for lack of memory: this "
                                    "process is limited to {} MiB, expected more. Set a higher limit (ulimit -v)\n",
                                    limit.rlim_cur >> 20);
  g_message_size = std::min(end.size, g_message.size());
  struct sigaction action = {};
  action.sa_handler = on_fault;
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) ::sigaction(signal, &action, nullptr);
}

}  // namespace multum
