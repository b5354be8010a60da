// SPDX-License-Identifier: Apache-2.0
// Keeps program binaries between runs. The key is the SHA-256 of source, options, device and driver version. A damaged
// or foreign file causes a rebuild, never an error.
#pragma once

#include <string>

namespace multum {

/// Sets the folder for binaries. An empty name, which is the default, turns the cache off. Programs call this once at
/// start.
void set_program_cache_folder(const std::string& folder);

/// Returns the SHA-256 of the sources of all kernels. Programs with other sources can give other results.
const std::string& kernel_sources_hash();

}  // namespace multum
