// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/file_ranges.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "host/foundation/base/error.h"

namespace multum {

FileRanges::FileRanges(const std::string& path, const std::vector<ByteRange>& ranges, std::vector<ByteRange> byte_words,
                       std::vector<BytePatch> patches)
    : path_(path), stream_(path), byte_words_(std::move(byte_words)), patches_(std::move(patches)) {
  for (const ByteRange& range : ranges) {
    pieces_.push_back({size_, range});
    size_ += range.end - range.begin;
  }
}

std::vector<unsigned char> FileRanges::read_all() {
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size_));
  if (read(bytes.data(), bytes.size(), 0) != bytes.size()) refuse_file(path_, "cannot be read");
  return bytes;
}

std::size_t FileRanges::read(void* data, std::size_t byte_count, std::int64_t offset) {
  const std::lock_guard<std::mutex> lock(mutex_);
  char* to = static_cast<char*>(data);
  auto next = std::upper_bound(pieces_.begin(), pieces_.end(), offset,
                               [](std::int64_t at, const Piece& piece) { return at < piece.offset; });
  if (next != pieces_.begin()) --next;
  for (; byte_count > 0 && next != pieces_.end(); ++next) {
    const std::int64_t begin = next->range.begin + (offset - next->offset);
    const auto count = std::min(static_cast<std::int64_t>(byte_count), next->range.end - begin);
    if (count <= 0) break;  // the range begins beyond the end
    stream_.clear();
    if (begin != stream_.tellg()) stream_.seekg(begin);
    stream_.read(to, count);
    const std::int64_t got = stream_.gcount();
    fill_words(begin, begin + got, to);
    apply_patches(begin, begin + got, to);
    to += got;
    offset += got;
    byte_count -= static_cast<std::size_t>(got);
    if (got < count) break;
  }
  return static_cast<std::size_t>(to - static_cast<char*>(data));
}

// Changes bytes [begin, end) of the file, which are stored at `data`. If the other byte of a word is outside this
// range, reads that byte separately.
void FileRanges::fill_words(std::int64_t begin, std::int64_t end, char* data) {
  for (const ByteRange& words : byte_words_) {
    for (std::int64_t at = std::max(begin, words.begin); at < std::min(end, words.end); ++at) {
      const std::int64_t other = words.begin + ((at - words.begin) ^ 1);
      char byte = 0;
      if (other >= begin && other < end) {
        byte = data[other - begin];
      } else {
        stream_.clear();
        stream_.seekg(other);
        stream_.get(byte);
      }
      if (data[at - begin] == 0) data[at - begin] = byte;
    }
  }
}

// Changes bytes [begin, end) of the file, which are stored at `data`.
void FileRanges::apply_patches(std::int64_t begin, std::int64_t end, char* data) const {
  for (const BytePatch& patch : patches_) {
    const auto patch_end = patch.position + static_cast<std::int64_t>(patch.bytes.size());
    for (std::int64_t at = std::max(begin, patch.position); at < std::min(end, patch_end); ++at)
      data[at - begin] = patch.bytes[static_cast<std::size_t>(at - patch.position)];
  }
}

}  // namespace multum
