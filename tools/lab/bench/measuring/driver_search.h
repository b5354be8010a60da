// SPDX-License-Identifier: Apache-2.0
// Finds drivers that are installed but unknown to the loaders. Containers with a GPU often have the maker's libraries
// without the files that name them. Makes these drivers known to the loaders of child processes, by means of files in a
// folder of this process.
//
//   OpenCL   /etc/OpenCL/vendors/*.icd, each the name of a library      OCL_ICD_VENDORS
//   EGL      glvnd/egl_vendor.d/*.json, each the name of a library      __EGL_VENDOR_LIBRARY_FILENAMES
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct FoundDriver {
  std::string library;   // path of the library
  std::string named_by;  // file that names the driver to the loader; empty if there is none
};

struct DriverSearch {
  std::vector<FoundDriver> opencl, egl;
};

/// Searches the list of ld.so, and the usual folders of driver makers and containers. Changes nothing.
DriverSearch find_drivers();

/// Registers the drivers that no file names, with files in `folder` and environment variables. Call it before any
/// thread starts.
void name_drivers(const DriverSearch& found, const std::string& folder);

}  // namespace multum::bench
