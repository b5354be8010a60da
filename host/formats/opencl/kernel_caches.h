// SPDX-License-Identifier: Apache-2.0
// Makes sure that compiled kernels can be kept: PoCL offers no device where its cache cannot be written. Where a folder
// cannot be (a home that is read-only, or another user's), a private one is used until the program ends.
#pragma once

#include <string>

namespace multum {

/// Folders that the environment names for compiled kernels.
struct KernelCacheFolders {
  std::string programs;  // of this project's binaries (program_cache.h); empty: none are kept
  std::string pocl;      // of PoCL; empty: it is left alone
};

/// Names the folders, before the first device is looked for. None is made or looked at until then.
void set_kernel_caches(const KernelCacheFolders& folders);

/// Makes the folders that are not there, and puts a private folder in the place of each that cannot be written: of mode
/// 0700, with a name that nobody can guess, below $TMPDIR or /tmp, removed when the program ends. MULTUM_CACHE_DIR and
/// POCL_CACHE_DIR name it then, for children too. Warns once, with the folder and the reason. Called before the first
/// platform is asked for; a program whose children open devices calls it before it starts them.
void prepare_kernel_caches();

/// Why PoCL cannot have a cache, with the folders that were tried; empty: it can, or was left alone.
const std::string& pocl_cache_failure();

}  // namespace multum
