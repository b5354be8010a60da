// SPDX-License-Identifier: Apache-2.0
// Policy of memory and disk: how much of an image or a level is held in memory, and the folder for the rest.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

namespace multum {

struct SpillPolicy {
  std::string scratch_folder = ".";
  std::int64_t memory_bytes =
      std::numeric_limits<std::int64_t>::max();  // of one store; larger ones go to scratch files
  int band_rows =
      0;  // rows of an image that are read or decoded at once, >= 0; 0: by their width. No result depends on it
};

}  // namespace multum
