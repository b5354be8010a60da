// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/result_archive.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "host/farm/service/files/result_listing.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

constexpr std::size_t kBlock = 512;
constexpr std::uint64_t kOctalSizeMax = (std::uint64_t{1} << 33) - 1;  // largest number in eleven octal digits
constexpr std::size_t kTarNameMax = 100;

std::size_t padding_of(std::uint64_t bytes) { return static_cast<std::size_t>((kBlock - bytes % kBlock) % kBlock); }

// Returns the two numbers of a file's state.
std::pair<std::uint64_t, std::int64_t> size_and_time(const std::string& state) {
  std::uint64_t size = 0;
  std::int64_t nanoseconds = 0;
  const char* end = state.data() + state.size();
  const auto first = std::from_chars(state.data(), end, size);
  if (first.ptr != end) std::from_chars(first.ptr + 1, end, nanoseconds);
  return {size, nanoseconds};
}

//   offset   0 name[100]  100 mode[8]  108 uid[8]  116 gid[8]  124 size[12]  136 time[12]  148 checksum[8]
//          156 type       157 link[100]  257 "ustar\0"  263 "00"  265 owner, group, device, prefix: empty here
std::string ustar_block(const std::string& name, char type, std::uint64_t size, std::int64_t seconds) {
  std::string block(kBlock, '\0');
  const auto put = [&](std::size_t at, const std::string& text) { block.replace(at, text.size(), text); };
  put(0, name.substr(0, kTarNameMax));
  put(100, "0000644");
  put(108, "0000000");
  put(116, "0000000");
  put(124, fmt::format("{:011o}", std::min(size, kOctalSizeMax)));
  put(136, fmt::format("{:011o}", std::clamp<std::int64_t>(seconds, 0, kOctalSizeMax)));
  put(148, "        ");
  block[156] = type;
  put(257, std::string("ustar\0"
                       "00",
                       8));
  unsigned sum = 0;
  for (const char c : block) sum += static_cast<unsigned char>(c);
  put(148, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  return block;
}

// Makes "LENGTH KEY=VALUE\n", where LENGTH includes its own digits.
std::string pax_record(const std::string& key, const std::string& value) {
  const std::size_t rest = key.size() + value.size() + 3;
  std::size_t length = rest + 1;
  while (std::to_string(length).size() + rest != length) ++length;
  return fmt::format("{} {}={}\n", length, key, value);
}

bool is_ascii(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > 0; });
}

}  // namespace

ResultArchive::ResultArchive(OpenFile folder, std::string name, const ResultSeal& seal)
    : folder_(std::move(folder)), name_(std::move(name)) {
  for (auto& [path, state] : published_files(folder_, name_, seal)) {
    open_published(folder_, path, state);
    files_.push_back({path, state});
    const std::uint64_t size = size_and_time(state).first;
    bytes_ += header(files_.back()).size() + size + padding_of(size);
  }
  if (files_.empty())
    throw Error(ErrorCode::kUsage, fmt::format("{}: holds no result that this service has published", name_));
  bytes_ += 2 * kBlock;
  // The archive's bytes depend only on these states.
  std::string states = name_ + '\n';
  for (const File& file : files_) states += file.state + ' ' + file.path + '\n';
  etag_ = '"' + hash_text(states).substr(0, 32) + '"';
}

std::size_t ResultArchive::memory() const {
  std::size_t bytes = 4 * kBlock;
  for (const File& file : files_) bytes += sizeof(File) + file.path.capacity() + file.state.capacity();
  return bytes;
}

// A pax header comes before the ustar header. The pax header has the values that do not fit into the ustar header. It
// also has the names, because the ustar header does not state their encoding.
std::string ResultArchive::header(const File& file) const {
  const std::string name = name_ + "/" + file.path;
  const auto [size, nanoseconds] = size_and_time(file.state);
  const std::int64_t seconds = nanoseconds / 1000000000;
  std::string records;
  if (text_of_message(name) != name) records += pax_record("hdrcharset", "BINARY");
  if (name.size() > kTarNameMax || !is_ascii(name)) records += pax_record("path", name);
  if (size > kOctalSizeMax) records += pax_record("size", std::to_string(size));
  std::string text;
  if (!records.empty()) {
    text = ustar_block("pax_header", 'x', records.size(), seconds) + records;
    text.resize(text.size() + padding_of(records.size()), '\0');
  }
  return text + ustar_block(name, '0', size, seconds);
}

void ResultArchive::begin_next() {
  sent_ = 0;
  if (next_ < files_.size()) {
    const File& file = files_[next_++];
    open_ = open_published(folder_, file.path, file.state);
    is_open_ = true;
    left_ = size_and_time(file.state).first;
    pending_ = header(file);
  } else {
    is_ended_ = true;
    pending_.assign(2 * kBlock, '\0');
  }
}

void ResultArchive::end_file() {
  const File& file = files_[next_ - 1];
  if (!is_in_state(open_, file.state))
    throw Error(ErrorCode::kUsage, fmt::format("{}: was changed while it was being sent", file.path));
  open_ = OpenFile();
  is_open_ = false;
  sent_ = 0;
  pending_.assign(padding_of(size_and_time(file.state).first), '\0');
}

// Writes the next bytes from one source, which is headers, padding or a file. Returns 0 at the end of the archive. If
// `to` is null, skips the bytes.
std::size_t ResultArchive::advance(char* to, std::uint64_t bytes_max) {
  for (;;) {
    if (sent_ < pending_.size()) {
      const std::size_t count = std::min<std::uint64_t>(bytes_max, pending_.size() - sent_);
      if (to != nullptr) std::memcpy(to, pending_.data() + sent_, count);
      sent_ += count;
      return count;
    }
    if (left_ > 0) {
      const std::uint64_t wanted = std::min(bytes_max, left_);
      const off_t moved = to == nullptr ? ::lseek(open_.descriptor(), static_cast<off_t>(wanted), SEEK_CUR) : 0;
      const ssize_t count =
          to == nullptr ? (moved < 0 ? -1 : static_cast<ssize_t>(wanted)) : ::read(open_.descriptor(), to, wanted);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) throw Error(ErrorCode::kUsage, fmt::format("{}: cannot be read further", files_[next_ - 1].path));
      left_ -= static_cast<std::uint64_t>(count);
      return static_cast<std::size_t>(count);
    }
    if (is_open_) end_file();
    else if (!is_ended_) begin_next();
    else return 0;
  }
}

std::size_t ResultArchive::read(char* to, std::size_t bytes_max) {
  std::size_t filled = 0;
  while (filled < bytes_max) {
    const std::size_t count = advance(to + filled, bytes_max - filled);
    if (count == 0) break;
    filled += count;
  }
  return filled;
}

void ResultArchive::skip(std::uint64_t bytes) {
  while (bytes > 0) {
    const std::size_t count = advance(nullptr, bytes);
    if (count == 0) throw Error(ErrorCode::kUsage, fmt::format("{}: is shorter than announced", name_));
    bytes -= count;
  }
}

}  // namespace multum
