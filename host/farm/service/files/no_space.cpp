// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/no_space.h"

#include <cerrno>
#include <cstring>

namespace multum {

bool is_no_space(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

void fail_to_write(const std::string& subject, const std::string& what) {
  const int error = errno;
  if (is_no_space(error))
    throw NoSpaceError(ErrorCode::kEnvironment,
                       subject + ": " + what + ": " + std::strerror(error) +
                           (error == EFBIG ? "; raise the limit of file sizes (ulimit -f, LimitFSIZE)" : ""));
  errno = error;
  fail_by_errno(subject, what);
}

}  // namespace multum
