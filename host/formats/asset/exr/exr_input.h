// SPDX-License-Identifier: Apache-2.0
// Lets OpenEXR read a file that host/foundation/base/files/regular_file has opened. If OpenEXR opened a FIFO by its
// name, it would wait for a writer.
#pragma once

#include <ImfIO.h>

#include <cstdint>
#include <string>

#include "host/foundation/base/files/regular_file.h"

namespace multum {

class ExrInputStream : public Imf::IStream {
 public:
  /// Throws Error(kInput) if the path is not a regular file, and throws an Iex exception if the file cannot be opened.
  explicit ExrInputStream(const std::string& path);

  // These functions throw Iex exceptions, as the library's own stream does.
  bool read(char values[], int count) override;
  std::uint64_t tellg() override { return static_cast<std::uint64_t>(std::streamoff(stream_.tellg())); }
  void seekg(std::uint64_t position) override { stream_.seekg(static_cast<std::streamoff>(position)); }
  void clear() override { stream_.clear(); }

 private:
  RegularFileStream stream_;
};

}  // namespace multum
