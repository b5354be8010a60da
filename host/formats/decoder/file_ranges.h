// SPDX-License-Identifier: Apache-2.0
// Presents byte ranges of a file to an image library as if they were the whole file. The result is a picture without
// its metadata, which is read on demand.
//   file       |signature IHDR|XMP ......|IDAT ........|text|IEND|
//   presented  |signature IHDR|IDAT ........|IEND|
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "host/formats/image/files/image_container.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {

class FileRanges {
 public:
  /// `byte_words` are ranges that contain 16-bit words `v * 256`. They are presented as `v * 257`, so that both bytes
  /// of a word have the larger value. `patches` are bytes that are presented instead of the file's bytes.
  FileRanges(const std::string& path, const std::vector<ByteRange>& ranges, std::vector<ByteRange> byte_words = {},
             std::vector<BytePatch> patches = {});

  /// Returns the number of bytes that were read. Several threads may call this function.
  std::size_t read(void* data, std::size_t byte_count, std::int64_t offset);
  /// Returns all bytes. Throws Error(kInput), which names the file, if it ends early.
  std::vector<unsigned char> read_all();
  std::int64_t size() const { return size_; }

 private:
  void fill_words(std::int64_t begin, std::int64_t end, char* data);
  void apply_patches(std::int64_t begin, std::int64_t end, char* data) const;

  struct Piece {
    std::int64_t offset;  // where the range is presented
    ByteRange range;      // where the range is in the file
  };
  std::string path_;
  RegularFileStream stream_;
  std::mutex mutex_;  // guards the stream
  std::vector<Piece> pieces_;
  std::int64_t size_ = 0;
  std::vector<ByteRange> byte_words_;
  std::vector<BytePatch> patches_;
};

}  // namespace multum
