// SPDX-License-Identifier: Apache-2.0
// Defines the error for a lack of disk space. The disk is full, or a quota or the file size limit (ulimit -f) is
// reached.
#pragma once

#include <string>

#include "host/foundation/base/error.h"

namespace multum {

/// The request is answered with status 507, because there may be enough space later. The refused request has no effect.
class NoSpaceError : public Error {
 public:
  using Error::Error;
};

/// Returns whether this errno reports a lack of space.
bool is_no_space(int error);

/// Like fail_by_errno(), but throws NoSpaceError if errno reports a lack of space.
[[noreturn]] void fail_to_write(const std::string& subject, const std::string& what);

}  // namespace multum
