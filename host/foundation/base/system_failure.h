// SPDX-License-Identifier: Apache-2.0
// Describes a failure of a system call, and the limit of this process that caused it.
#pragma once

#include <string>

#include "host/foundation/base/error.h"

namespace multum {

/// Returns the meaning of `number`, a value of errno. If a limit of this process explains the error, adds the limit,
/// its value and the option of the shell's ulimit that sets it: "File too large; files may have 1048576 bytes (ulimit
/// -f)".
std::string errno_text(int number);

/// Returns the error code for a value of errno. The code is kUsage for a name that is too long for the file system,
/// because another attempt cannot help; otherwise kEnvironment.
ErrorCode errno_code(int number);

/// Called in a catch block: returns the exception as an Error, for loops that continue with the next file. Returns an
/// Error unchanged; turns exhausted memory and system failures (std::bad_alloc, std::system_error) into an Error
/// about `subject`. Rethrows all other exceptions, so that Cancelled and faults of the program end the loop.
Error caught_error(const std::string& subject);

}  // namespace multum
