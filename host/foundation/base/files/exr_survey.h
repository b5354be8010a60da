// SPDX-License-Identifier: Apache-2.0
// Examines an OpenEXR file's headers ("OpenEXR file layout") by our own few lines: the library believes what they say
// of their lengths, and takes gigabytes for an attribute of a file of 30 KiB.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/foundation/base/files/byte_file.h"

namespace multum {

struct ExrPartSize {
  std::int64_t width = 0, height = 0;  // of the data window, at least 1
  std::string subsampled = {};         // a channel that has fewer samples than texels; empty: none
};

struct ExrAttribute {
  int part;
  std::string name, type;       // as the file has them
  std::int64_t position, size;  // of the value, all of it within the file
};

/// Every attribute of every header, in the file's order. `end_part` is called behind each part's. Throws Error(kInput)
/// where headers are cut or damaged, and whatever the functions throw.
void walk_exr_headers(const std::string& path, ByteFile& file, const std::function<void(const ExrAttribute&)>& visit,
                      const std::function<void()>& end_part = {});

/// At least one part. Throws Error(kInput): deep, cut, attributes beyond the end of the file, sizes whose table of
/// chunks does not fit into it.
std::vector<ExrPartSize> survey_exr(const std::string& path, ByteFile& file);

/// Checks the first bytes and the headers before a library opens the file; leaves it to who opens it to refuse what is
/// not there. `otherwise`: what the refusal says first, as "not a readable baked file". Throws Error(kInput).
void check_exr_headers(const std::string& path, const std::string& otherwise);

}  // namespace multum
