// SPDX-License-Identifier: Apache-2.0
// Examines the headers of an OpenEXR file ("OpenEXR file layout") without the library. The library trusts the lengths
// in the headers. For a file of 30 KiB, it can therefore allocate gigabytes for one attribute.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/foundation/base/files/byte_file.h"

namespace multum {

struct ExrPartSize {
  std::int64_t width = 0, height = 0;  // size of the data window, at least 1
  std::string subsampled = {};         // name of a channel with fewer samples than texels; empty if there is none
};

struct ExrAttribute {
  int part;
  std::string name, type;       // as stored in the file
  std::int64_t position, size;  // place of the value, which is entirely within the file
};

/// Visits every attribute of every header, in the order of the file, and calls `end_part` after each header. Throws
/// Error(kInput) if a header is cut or damaged. Exceptions that the two functions throw are passed on.
void walk_exr_headers(const std::string& path, ByteFile& file, const std::function<void(const ExrAttribute&)>& visit,
                      const std::function<void()>& end_part = {});

/// Returns the parts of the file, at least one. Throws Error(kInput) for deep images, cut files, attributes beyond the
/// end of the file, and image sizes whose chunk table does not fit into the file.
std::vector<ExrPartSize> survey_exr(const std::string& path, ByteFile& file);

/// Checks the first bytes and the headers before a library opens the file. Accepts a missing file, because the library
/// itself rejects it. Messages begin with `otherwise`, for example "not a readable baked file". Throws Error(kInput).
void check_exr_headers(const std::string& path, const std::string& otherwise);

}  // namespace multum
