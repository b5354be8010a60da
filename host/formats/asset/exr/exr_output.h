// SPDX-License-Identifier: Apache-2.0
// Adds two features to OpenEXR's output. First, the stream keeps its first error. The library's own stream loses errors
// in the tables of tiles, which are written last. Second, headers can be filled in after the pixels are written.
#pragma once

#include <ImfIO.h>

#include <functional>
#include <string>

#include "host/foundation/base/files/output_file.h"

namespace multum {

class ExrOutputStream : public Imf::OStream {
 public:
  /// Throws like OutputFile.
  explicit ExrOutputStream(const AtomicFile& file);

  void write(const char values[], int count) override;
  std::uint64_t tellp() override { return file_.position(); }
  void seekp(std::uint64_t position) override;
  void close() { file_.close(); }

 private:
  OutputFile file_;
};

/// Writes a file that appears complete or not at all. `write` writes its contents. Throws Error(kEnvironment) if the
/// disk or OpenEXR fails.
void write_exr_file(const std::string& path, const std::function<void(Imf::OStream& stream)>& write);

/// Writes `text`, padded with spaces, over the string attribute `name` in every header that has the attribute. Returns
/// the number of these headers. Throws Error(kEnvironment) if the room is too small or the disk fails.
int fill_in_attribute(const AtomicFile& file, const std::string& name, const std::string& text);

}  // namespace multum
