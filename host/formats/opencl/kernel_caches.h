// SPDX-License-Identifier: Apache-2.0
// Makes sure that compiled kernels can be stored, because PoCL offers no device if its cache cannot be written. If a
// folder is not writable (a read-only home, or another user's folder), a private folder replaces it until the program
// ends.
#pragma once

#include <string>

namespace multum {

/// The folders for compiled kernels, according to the environment.
struct KernelCacheFolders {
  std::string programs;  // folder for this project's binaries (program_cache.h); if empty, none are stored
  std::string pocl;      // folder for PoCL; if empty, PoCL's settings stay unchanged
};

/// Returns the folders that environment variables name. `variable` returns the value of a variable, or null. Programs
/// go to $MULTUM_CACHE_DIR, or to the folder "multum" in the user's cache ($XDG_CACHE_HOME, or ~/.cache). If
/// $MULTUM_CACHE_DIR is empty, no programs are stored. PoCL finds its folder in the same way.
KernelCacheFolders kernel_cache_folders(const char* (*variable)(const char* name));

/// Sets the folders. Call this function before the search for devices. It does not access the folders yet.
void set_kernel_caches(const KernelCacheFolders& folders);

/// Makes missing folders, and replaces each folder that cannot be written by a private one. The private folder has mode
/// 0700 and a random name below $TMPDIR or /tmp, and is removed when the program ends. MULTUM_CACHE_DIR and
/// POCL_CACHE_DIR then name the private folder, for child processes too. Warns once, with the folder and the reason.
/// This function is called before the first platform is used. A program whose child processes open devices calls this
/// function before it starts the child processes.
void prepare_kernel_caches();

/// Returns the reason why PoCL has no cache, with the folders that were tried. Returns an empty text if PoCL has a
/// cache or its settings were not changed.
const std::string& pocl_cache_failure();

}  // namespace multum
