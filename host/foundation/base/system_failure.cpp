// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/system_failure.h"

#include <sys/resource.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>

namespace multum {
namespace {

// Returns "" if the process has no such limit.
std::string limit_text(__rlimit_resource which, const char* before, const char* after) {
  rlimit limit = {};
  if (::getrlimit(which, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
  return std::string("; ") + before + std::to_string(limit.rlim_cur) + after;
}

std::string text_of(const std::system_error& error) {
  const bool is_errno =
      error.code().category() == std::generic_category() || error.code().category() == std::system_category();
  if (!is_errno) return error.what();
  const std::string text = error.what(), more = errno_text(error.code().value());
  const std::string plain = std::strerror(error.code().value());
  return text + (more.size() > plain.size() ? more.substr(plain.size()) : "");
}

}  // namespace

std::string errno_text(int number) {
  std::string limit;
  if (number == EFBIG) limit = limit_text(RLIMIT_FSIZE, "files may have ", " bytes (ulimit -f)");
  if (number == EMFILE) limit = limit_text(RLIMIT_NOFILE, "this process may have ", " files open (ulimit -n)");
  if (number == ENOMEM) limit = limit_text(RLIMIT_AS, "this process may take ", " bytes of memory (ulimit -v)");
  // The stack of a thread also needs memory.
  if (number == EAGAIN)
    limit = limit_text(RLIMIT_NPROC, "this user may have ", " threads (ulimit -u)") +
            limit_text(RLIMIT_AS, "this process may take ", " bytes of memory (ulimit -v)");
  return std::strerror(number) + limit;
}

ErrorCode errno_code(int number) { return number == ENAMETOOLONG ? ErrorCode::kUsage : ErrorCode::kEnvironment; }

Error caught_error(const std::string& subject) {
  const std::string about = subject.empty() ? "" : subject + ": ";
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return Error(ErrorCode::kEnvironment,
                 about + "out of memory" + limit_text(RLIMIT_AS, "this process may take ", " bytes (ulimit -v)"));
  } catch (const std::system_error& error) {
    return Error(errno_code(error.code().value()), about + text_of(error));
  }
}

}  // namespace multum
