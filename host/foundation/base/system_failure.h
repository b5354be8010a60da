// SPDX-License-Identifier: Apache-2.0
// Describes a failure of a system call, and the limit of this process that caused it.
#pragma once

#include <string>

#include "host/foundation/base/error.h"

namespace multum {

/// Returns the meaning of `number`, a value of errno. If a limit of this process explains the error, the text also
/// gives the limit, its value and the option of the shell's ulimit command that sets it: "File too large; files may
/// have 1048576 bytes (ulimit -f)".
std::string errno_text(int number);

/// Returns the error code for a value of errno. If a name is too long for the file system, the code is kUsage, because
/// another attempt cannot help. Otherwise, the code is kEnvironment.
ErrorCode errno_code(int number);

/// Called in a catch block: returns the exception as an Error, for loops that continue with the next file. An Error is
/// returned unchanged. Exhausted memory and system failures (std::bad_alloc, std::system_error) become an Error about
/// `subject`. All other exceptions are rethrown, so that Cancelled and faults of the program end the loop.
Error caught_error(const std::string& subject);

}  // namespace multum
