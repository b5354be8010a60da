// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/record_journal.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <utility>
#include <vector>

#include "host/base/error.h"
#include "host/base/files/checksum.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kChecksumBytes = 16;  // of Checksum::text()

std::array<std::uint8_t, kLengthBytes> length_bytes(std::uint64_t length) {
  std::array<std::uint8_t, kLengthBytes> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(length >> (8 * i));
  return bytes;
}

std::uint64_t length_of(const std::array<std::uint8_t, kLengthBytes>& bytes) {
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) length |= std::uint64_t{bytes[i]} << (8 * i);
  return length;
}

template <typename Bytes>
void write(std::ofstream& out, const Bytes& bytes) {
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

template <typename Bytes>
void read_into(std::ifstream& in, Bytes& bytes) {
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

std::unique_ptr<RecordJournal> RecordJournal::open(const std::string& output, const std::string& file,
                                                   const std::string& key, bool resume, const Visit& visit) {
  std::unique_ptr<PartialFolder> folder = PartialFolder::take(output);
  if (folder == nullptr) return nullptr;
  std::unique_ptr<RecordJournal> journal(new RecordJournal(std::move(folder), file));
  if (const std::uint64_t bytes = resume ? journal->read(key, visit) : 0; bytes > 0) {
    std::error_code ignored;
    fs::resize_file(journal->path_, bytes, ignored);
    return journal;
  }
  journal->folder_->clear();
  std::ofstream out(journal->path_, std::ios::binary);
  out << key << '\n';
  if (!out.flush()) journal->fail();
  return journal;
}

RecordJournal::RecordJournal(std::unique_ptr<PartialFolder> folder, const std::string& file)
    : folder_(std::move(folder)), path_(folder_->path() + "/" + file) {}

void RecordJournal::fail() const {
  throw Error(ErrorCode::kEnvironment, path_ + ": cannot be written: " + std::strerror(errno));
}

std::uint64_t RecordJournal::read(const std::string& key, const Visit& visit) const {
  std::ifstream in(path_, std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line != key) return 0;
  std::uint64_t good = line.size() + 1;
  std::error_code error;
  const std::uint64_t size = fs::file_size(path_, error);
  while (!error && size - good >= kLengthBytes + kChecksumBytes) {
    std::array<std::uint8_t, kLengthBytes> head{};
    read_into(in, head);
    const std::uint64_t length = length_of(head);
    if (!in || length > size - good - kLengthBytes - kChecksumBytes) break;
    std::vector<std::uint8_t> bytes(length);
    std::string found(kChecksumBytes, ' ');
    read_into(in, bytes);
    read_into(in, found);
    Checksum checksum;
    checksum.update(bytes.data(), bytes.size());
    if (!in || checksum.text() != found || !visit(bytes, good + kLengthBytes)) break;
    good += kLengthBytes + length + kChecksumBytes;
  }
  return good;
}

void RecordJournal::add(std::initializer_list<std::span<const std::uint8_t>> parts) {
  std::uint64_t length = 0;
  Checksum checksum;
  for (const auto& part : parts) {
    length += part.size();
    checksum.update(part.data(), part.size());
  }
  MULTUM_CHECK(length <= std::numeric_limits<std::uint32_t>::max());
  const std::lock_guard lock(mutex_);
  std::ofstream out(path_, std::ios::binary | std::ios::app);
  write(out, length_bytes(length));
  for (const auto& part : parts) write(out, part);
  write(out, checksum.text());
  if (!out.flush()) fail();
}

}  // namespace multum
