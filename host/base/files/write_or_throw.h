// SPDX-License-Identifier: Apache-2.0
// Writes where nothing stands between the writer and whoever may hear of a failure.
#pragma once

#include <cstddef>

#include "host/base/files/output_file.h"

namespace multum {

/// Writes to a file that is not closed yet, and ends the work at once when the system refuses: hours of work would be
/// for nothing. Throws Error(kEnvironment).
inline void write_or_throw(OutputFile& file, const void* bytes, std::size_t count) {
  if (!file.write(bytes, count)) file.close();  // throws what has failed
}

}  // namespace multum
