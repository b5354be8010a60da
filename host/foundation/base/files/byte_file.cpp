// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/byte_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

constexpr std::int64_t kWindowBytes = 4096;  // headers are read byte by byte, and a stream discards its buffer at each
                                             // seek

}  // namespace

ByteFile::ByteFile(const std::string& path) : ByteFile(open_regular_file(path), path) {}

ByteFile::ByteFile(OpenFile file, const std::string& path) : path_(path), file_(std::move(file)) {
  if (!file_.is_open() && errno == ENOENT) refuse_file(path, "no such file");
  struct stat found {};
  if (!file_.is_open() || ::fstat(file_.descriptor(), &found) != 0)
    refuse_file(path, std::string("cannot be read: ") + std::strerror(errno));
  size_ = static_cast<std::int64_t>(found.st_size);
}

std::string ByteFile::bytes(std::int64_t position, std::int64_t count, const char* what) {
  check_range(position, count, what);
  if (position < window_begin_ || position + count > window_begin_ + static_cast<std::int64_t>(window_.size())) {
    std::string window(static_cast<std::size_t>(std::min(std::max(count, kWindowBytes), size_ - position)), '\0');
    read(position, static_cast<std::int64_t>(window.size()), window.data(), what);
    window_ = std::move(window);
    window_begin_ = position;
  }
  return window_.substr(static_cast<std::size_t>(position - window_begin_), static_cast<std::size_t>(count));
}

void ByteFile::check_range(std::int64_t position, std::int64_t count, const char* what) const {
  if (position < 0 || count < 0 || position > size_ - count)
    refuse_file(
        path_, fmt::format("the file is cut short: it ends at byte {}, expected {} at byte {}", size_, what, position));
}

void ByteFile::read(std::int64_t position, std::int64_t count, void* memory, const char* what) const {
  check_range(position, count, what);
  for (std::int64_t done = 0; done < count;) {
    const ssize_t got = ::pread(file_.descriptor(), static_cast<char*>(memory) + done,
                                static_cast<std::size_t>(count - done), static_cast<off_t>(position + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) refuse_file(path_, fmt::format("reading {} at byte {} failed", what, position));
    done += got;
  }
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
