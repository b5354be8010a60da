// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/byte_file.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr std::int64_t kWindowBytes = 4096;  // headers are read byte by byte, and each seek of a stream reads anew

}  // namespace

ByteFile::ByteFile(const std::string& path) : path_(path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) refuse_file(path, "no such file");
  if (!std::filesystem::is_regular_file(path, error)) refuse_file(path, "is not a file");
  stream_.open(path, std::ios::binary);
  size_ = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (!stream_ || error) refuse_file(path, "cannot be read");
}

std::string ByteFile::bytes(std::int64_t position, std::int64_t count, const char* what) {
  if (position < 0 || count < 0 || position > size_ - count)
    refuse_file(path_,
                fmt::format("the file is cut: it ends at byte {}, expected {} at byte {}", size_, what, position));
  if (position < window_begin_ || position + count > window_begin_ + static_cast<std::int64_t>(window_.size())) {
    window_begin_ = position;
    window_.resize(static_cast<std::size_t>(std::min(std::max(count, kWindowBytes), size_ - position)));
    stream_.seekg(position);
    stream_.read(window_.data(), static_cast<std::streamsize>(window_.size()));
    if (!stream_) refuse_file(path_, fmt::format("reading {} at byte {} failed", what, position));
  }
  return window_.substr(static_cast<std::size_t>(position - window_begin_), static_cast<std::size_t>(count));
}

std::int64_t ByteFile::big_endian(std::int64_t position, int count, const char* what) {
  std::int64_t value = 0;
  for (const char byte : bytes(position, count, what)) value = value * 256 + static_cast<unsigned char>(byte);
  return value;
}

std::int64_t ByteFile::little_endian(std::int64_t position, int count, const char* what) {
  std::string raw = bytes(position, count, what);
  std::reverse(raw.begin(), raw.end());
  std::int64_t value = 0;
  for (const char byte : raw) value = value * 256 + static_cast<unsigned char>(byte);
  return value;
}

std::string bytes_of_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || bytes.empty()) throw Error(ErrorCode::kEnvironment, path + ": cannot be read");
  return bytes;
}

}  // namespace multum
