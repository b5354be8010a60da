// SPDX-License-Identifier: Apache-2.0
// Says what the system refused, and which limit of this process was in the way.
#pragma once

#include <string>

#include "host/foundation/base/error.h"

namespace multum {

/// What `number`, a value of errno, means; where a limit of this process explains it, the limit, its value and the
/// option of the shell's ulimit that sets it: "File too large; files may have 1048576 bytes (ulimit -f)".
std::string errno_text(int number);

/// Kind of an error of errno: kUsage of a name that is too long for the file system, which no other try makes shorter;
/// else kEnvironment.
ErrorCode errno_code(int number);

/// Within a catch block: the exception as an Error, for loops over files that go on with the next one. An Error is
/// returned as it is; memory that has run out and what the system refuses (std::bad_alloc, std::system_error) become
/// an Error about `subject`. Rethrows everything else: Cancelled ends the loop too, and so does a fault of the program.
Error caught_error(const std::string& subject);

}  // namespace multum
