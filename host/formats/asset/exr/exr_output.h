// SPDX-License-Identifier: Apache-2.0
// Adds what OpenEXR's own output lacks: a stream that keeps the first thing that went wrong (the library's stream loses
// what fails while the tables of tiles are written, last of all), and headers that are filled in when the pixels are
// written.
#pragma once

#include <ImfIO.h>

#include <functional>
#include <string>

#include "host/foundation/base/files/output_file.h"

namespace multum {

class ExrOutputStream : public Imf::OStream {
 public:
  /// As OutputFile.
  explicit ExrOutputStream(const AtomicFile& file);

  void write(const char values[], int count) override;
  std::uint64_t tellp() override { return file_.position(); }
  void seekp(std::uint64_t position) override;
  void close() { file_.close(); }

 private:
  OutputFile file_;
};

/// A file of its own that appears whole or not at all; `write` gives it its bytes. Throws Error(kEnvironment) when the
/// disk or OpenEXR refuses.
void write_exr_file(const std::string& path, const std::function<void(Imf::OStream& stream)>& write);

/// Writes `text`, padded with spaces, over the string attribute `name` in every header of the file that has it, and
/// returns how many have. Throws Error(kEnvironment) where the room is less or the disk refuses.
int fill_in_attribute(const AtomicFile& file, const std::string& name, const std::string& text);

}  // namespace multum
