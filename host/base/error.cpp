// SPDX-License-Identifier: Apache-2.0
#include "host/base/error.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "host/base/shown_text.h"

namespace multum {

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
  try {
    return body(argc, argv);
  } catch (const Cancelled&) {
    print_shown(stderr, "%s: cancelled, nothing unfinished was kept\n", program);
    return 130;
  } catch (const Error& error) {
    print_shown(stderr, "%s: %s\n", program, error.what());
    return exit_code(error.code());
  } catch (const std::bad_alloc&) {
    print_shown(stderr, "%s: out of memory\n", program);
    return exit_code(ErrorCode::kEnvironment);
  } catch (const std::exception& error) {
    print_shown(stderr, "%s: unexpected error: %s\n", program, error.what());
    return 1;
  }
}

void refuse_file(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kInput, path + ": " + what);
}

void fail_by_errno(const std::string& subject, const std::string& what) {
  throw Error(ErrorCode::kEnvironment, subject + ": " + what + ": " + std::strerror(errno));
}

void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: check failed: %s\n", file, line, condition);
  std::abort();
}

}  // namespace multum
