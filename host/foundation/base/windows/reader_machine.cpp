// SPDX-License-Identifier: Apache-2.0
// Implements for Windows what readers use of host/foundation/base/processes/machine.h and
// host/foundation/base/system_failure.h.
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>
#include <thread>

#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/system_failure.h"

namespace multum {

int processor_count() {
  const unsigned count = std::thread::hardware_concurrency();
  return count == 0 ? 1 : static_cast<int>(count);
}

std::string own_program() { return _pgmptr; }

std::string errno_text(int number) { return std::strerror(number); }

ErrorCode errno_code(int number) { return number == ENAMETOOLONG ? ErrorCode::kUsage : ErrorCode::kEnvironment; }

Error caught_error(const std::string& subject) {
  const std::string about = subject.empty() ? "" : subject + ": ";
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    return Error(ErrorCode::kEnvironment, about + "out of memory");
  } catch (const std::system_error& error) {
    return Error(errno_code(error.code().value()), about + error.what());
  }
}

}  // namespace multum
