// SPDX-License-Identifier: Apache-2.0
// Keeps program binaries between runs, keyed by SHA-256 of source, options, device and driver version. A damaged or
// foreign file causes a rebuild, never an error.
#pragma once

#include <string>

namespace multum {

/// Sets the folder for binaries; empty turns the cache off (the default). Programs set it once at start.
void set_program_cache_folder(const std::string& folder);

/// Returns the SHA-256 of all kernels' sources; programs with other sources can give other results.
const std::string& kernel_sources_hash();

}  // namespace multum
