// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/error.h"

#include <unistd.h>

#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/messages/stream_turn.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

// Rewrites "/proc/PID/fd/N/rows" as "/maps/.multum-partial-a.exr/rows" while descriptor N is open.
std::string with_names(std::string message) {
  const std::string own = "/proc/" + std::to_string(::getpid()) + "/fd/";
  for (std::size_t at = message.find(own); at != std::string::npos; at = message.find(own, at + 1)) {
    std::size_t end = at + own.size();
    while (end < message.size() && message[end] >= '0' && message[end] <= '9') ++end;
    char name[PATH_MAX];
    const ssize_t length = ::readlink(message.substr(at, end - at).c_str(), name, sizeof(name));
    if (length > 0) message.replace(at, end - at, name, static_cast<std::size_t>(length));
  }
  return message;
}

}  // namespace

Error::Error(ErrorCode code, const std::string& message)
    : std::runtime_error(with_names(with_advice(message))), code_(code) {}

int exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage: return 2;
    case ErrorCode::kInput: return 3;
    case ErrorCode::kEnvironment: return 4;
    case ErrorCode::kVerification: return 5;
  }
  return 1;
}

int run_guarded(const char* program, int (*body)(int, char**), int argc, char** argv) {
  // By default, SIGXFSZ ends the program in the middle of its work. If the program ignores SIGXFSZ, a write beyond the
  // file size limit (ulimit -f) fails with EFBIG, just as a write to a full disk fails with ENOSPC. Other programs that
  // this program starts get the default action back (spawn_process()). If such a program belongs to this project, it
  // ignores the signal itself when it runs this line.
  std::signal(SIGXFSZ, SIG_IGN);
  begin_whole_lines();
  try {
    try {
      return body(argc, argv);
    } catch (...) {
      throw caught_error("");
    }
  } catch (const Cancelled&) {
    print_shown(stderr, "%s: cancelled; no unfinished files remain\n", program);
    return 130;
  } catch (const Error& error) {
    print_shown(stderr, "%s: %s\n", program, error.what());
    return exit_code(error.code());
  } catch (const std::exception& error) {
    print_shown(stderr, "%s: unexpected error: %s\n", program, error.what());
    return 1;
  }
}

void refuse_file(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kInput, path + ": " + what);
}

void fail_by_errno(const std::string& subject, const std::string& what) {
  const int number = errno;  // saved, because the calls below can change errno
  throw Error(errno_code(number), subject + ": " + what + ": " + errno_text(number));
}

}  // namespace multum
