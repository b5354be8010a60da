// SPDX-License-Identifier: Apache-2.0
// Program binaries kept between runs, keyed by SHA-256 of source, options, device and driver version. A damaged or
// foreign file means a rebuild, never an error.
#pragma once

#include <string>

namespace multum {

/// Sets the folder where binaries are kept; empty turns the cache off. Programs set it once at start (default: off).
void set_program_cache_folder(const std::string& folder);

/// SHA-256 of all kernels' sources: what was made with others may differ.
const std::string& kernel_sources_hash();

}  // namespace multum
