// SPDX-License-Identifier: Apache-2.0
// Limits the memory of images and levels, and names the folder for larger data.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace multum {

struct SpillPolicy {
  std::string scratch_folder = ".";
  std::int64_t memory_bytes = std::numeric_limits<std::int64_t>::max();  // memory limit of each store; data beyond it
                                                                         // go to scratch files
  int band_rows = 0;  // number of image rows that are read or decoded at once; 0 chooses it from the width; does not
                      // change results
};

}  // namespace multum
