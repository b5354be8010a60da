// SPDX-License-Identifier: Apache-2.0
#include "host/decoder/file_ranges.h"

#include <algorithm>
#include <iterator>

namespace multum {

FileRanges::FileRanges(const std::string& path, const std::vector<ByteRange>& ranges)
    : IOProxy(path, Read), stream_(path, std::ios::binary) {
  for (const ByteRange& range : ranges) {
    pieces_.push_back({size_, range});
    size_ += range.end - range.begin;
  }
}

std::size_t FileRanges::read(void* data, std::size_t byte_count) {
  const std::size_t got = pread(data, byte_count, m_pos);
  m_pos += static_cast<std::int64_t>(got);
  return got;
}

std::size_t FileRanges::pread(void* data, std::size_t byte_count, std::int64_t offset) {
  const std::lock_guard<std::mutex> lock(mutex_);
  char* to = static_cast<char*>(data);
  auto next = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                               [](std::int64_t at, const Piece& piece) { return at < piece.offset; });
  if (next != pieces_.begin()) --next;
  for (; byte_count > 0 && next != pieces_.end(); ++next) {
    const std::int64_t begin = next->range.begin + (offset - next->offset);
    const auto count = std::min(static_cast<std::int64_t>(byte_count), next->range.end - begin);
    if (count <= 0) break;  // beyond the end
    stream_.clear();
    if (begin != stream_.tellg()) stream_.seekg(begin);
    stream_.read(to, count);
    const std::int64_t got = stream_.gcount();
    to += got;
    offset += got;
    byte_count -= static_cast<std::size_t>(got);
    if (got < count) break;
  }
  return static_cast<std::size_t>(to - static_cast<char*>(data));
}

}  // namespace multum
