// SPDX-License-Identifier: Apache-2.0
// Serves requests of the parent process. This is the child's side of host/foundation/sandbox/helper_process.h.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

inline constexpr int kHelperSocket = 3;
inline constexpr int kHelperMemory = 4;

/// Confines this process to reading, and answers requests until the parent process has ended. Returns the exit code.
/// The code is 2 if no parent process sends requests, because a user started the program. Throws Error(kEnvironment) if
/// the process cannot be confined although the system says that it can.
int serve_helper(const std::function<std::string(std::string_view request, SharedMemory& memory)>& answer);

}  // namespace multum
