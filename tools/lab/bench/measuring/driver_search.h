// SPDX-License-Identifier: Apache-2.0
// Finds drivers that a machine has and its loaders do not know: a container that is lent a GPU often has the maker's
// libraries without the files that name them. They are named to the loaders for this process's children, in a folder of
// its own.
//
//   OpenCL   /etc/OpenCL/vendors/*.icd, each the name of a library      OCL_ICD_VENDORS
//   EGL      glvnd/egl_vendor.d/*.json, the same                        __EGL_VENDOR_LIBRARY_FILENAMES
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct FoundDriver {
  std::string library;   // its path
  std::string named_by;  // the file that names it to the loader; empty: none did
};

struct DriverSearch {
  std::vector<FoundDriver> opencl, egl;
};

/// Looks in ld.so's list and in the folders that makers and containers use. Changes nothing.
DriverSearch find_drivers();

/// Names those that nothing names, by files in `folder` and variables of the environment. Before any thread starts.
void name_drivers(const DriverSearch& found, const std::string& folder);

}  // namespace multum::bench
