// SPDX-License-Identifier: Apache-2.0
// What OpenEXR's own output lacks: a stream that keeps the first thing that went wrong (the library's stream loses what
// fails while the tables of tiles are written, last of all), and headers that are filled in when the pixels are
// written.
#pragma once

#include <ImfIO.h>

#include <cstdio>
#include <string>

namespace multum {

class ExrOutputStream : public Imf::OStream {
 public:
  /// Creates `path`; messages name `shown_path`. Throws Error(kEnvironment).
  ExrOutputStream(const std::string& path, const std::string& shown_path);
  ~ExrOutputStream() override;

  void write(const char values[], int count) override;
  std::uint64_t tellp() override { return position_; }
  void seekp(std::uint64_t position) override;
  /// Hands everything to the system. Throws Error(kEnvironment) when this or anything before it failed.
  void close();

 private:
  void note_failure();
  std::FILE* file_ = nullptr;
  std::uint64_t position_ = 0;
  int failure_ = 0;  // the first errno
};

/// Writes `text`, padded with spaces, over the string attribute `name` in every header of the file that has it, and
/// returns how many have. Throws Error(kEnvironment), naming `shown_path`, where the room is less or the disk refuses.
int fill_in_attribute(const std::string& path, const std::string& shown_path, const std::string& name,
                      const std::string& text);

}  // namespace multum
