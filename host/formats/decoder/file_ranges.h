// SPDX-License-Identifier: Apache-2.0
// Byte ranges of a file, presented to OpenImageIO as if they were the whole file: a picture without its metadata, read
// as it is needed. (OpenImageIO 2.4's PNG reader takes it; its JPEG reader takes files and memory alone.)
//   file       |signature IHDR|XMP ......|IDAT ........|text|IEND|
//   presented  |signature IHDR|IDAT ........|IEND|
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include <OpenImageIO/filesystem.h>

#include "host/formats/image/files/image_container.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {

class FileRanges : public OIIO::Filesystem::IOProxy {
 public:
  /// `byte_words`: 16-bit words v * 256 of the file, presented as v * 257: both bytes are the larger of the two.
  /// `patches`: presented in place of what the file has there.
  FileRanges(const std::string& path, const std::vector<ByteRange>& ranges, std::vector<ByteRange> byte_words = {},
             std::vector<BytePatch> patches = {});

  const char* proxytype() const override { return "file ranges"; }
  std::size_t read(void* data, std::size_t byte_count) override;
  std::size_t pread(void* data, std::size_t byte_count, std::int64_t offset) override;
  std::size_t size() const override { return static_cast<std::size_t>(size_); }

 private:
  void fill_words(std::int64_t begin, std::int64_t end, char* data);
  void apply_patches(std::int64_t begin, std::int64_t end, char* data) const;

  struct Piece {
    std::int64_t offset;  // where it is presented
    ByteRange range;      // where it lies in the file
  };
  RegularFileStream stream_;
  std::mutex mutex_;  // of the stream
  std::vector<Piece> pieces_;
  std::int64_t size_ = 0;
  std::vector<ByteRange> byte_words_;
  std::vector<BytePatch> patches_;
};

}  // namespace multum
