// SPDX-License-Identifier: Apache-2.0
// A disk that takes no more: it is full, or a quota or the limit of file sizes (ulimit -f) is reached.
#pragma once

#include <string>

#include "host/foundation/base/error.h"

namespace multum {

/// Answered with 507: there may be room later, and nothing of what was asked for is done.
class NoSpaceError : public Error {
 public:
  using Error::Error;
};

/// Does this errno say so?
bool is_no_space(int error);

/// As fail_by_errno(); throws NoSpaceError where errno says that there is no space.
[[noreturn]] void fail_to_write(const std::string& subject, const std::string& what);

}  // namespace multum
