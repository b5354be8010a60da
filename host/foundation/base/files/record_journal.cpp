// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/record_journal.h"

#include <array>
#include <limits>
#include <utility>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/checksum.h"

namespace multum {
namespace {

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

}  // namespace

std::unique_ptr<RecordJournal> RecordJournal::open(const std::string& output, const std::string& file,
                                                   const std::string& key, bool resume, const Visit& visit) {
  std::unique_ptr<WorkFolder> folder = WorkFolder::take(partial_folder_of(output));
  if (folder == nullptr) return nullptr;
  if (!resume) folder->clear();
  std::unique_ptr<RecordJournal> journal(new RecordJournal(std::move(folder), file));
  const std::uint64_t bytes = resume ? journal->visit_records(key, visit) : 0;
  journal->file_.cut(bytes);
  if (bytes == 0) {
    journal->folder_->clear(file);
    journal->file_.append_line(key);
  }
  return journal;
}

RecordJournal::RecordJournal(std::unique_ptr<WorkFolder> folder, const std::string& file)
    : folder_(std::move(folder)), file_(*folder_, file) {}

std::uint64_t RecordJournal::visit_records(const std::string& key, const Visit& visit) const {
  if (file_.line(0, key.size()) != key) return 0;
  std::uint64_t good = key.size() + 1;
  std::vector<std::uint8_t> bytes;
  while (file_.size() - good >= kLengthBytes + kChecksumBytes) {
    std::array<std::uint8_t, kLengthBytes> head{};
    if (!file_.read(good, head)) break;
    const std::uint64_t length = length_of(head);
    if (length > file_.size() - good - kLengthBytes - kChecksumBytes) break;
    bytes.resize(length + kChecksumBytes);
    if (!file_.read(good + kLengthBytes, bytes)) break;
    const std::span<const std::uint8_t> record = std::span(bytes).first(length);
    Checksum checksum;
    checksum.update(record.data(), record.size());
    const std::string found(bytes.begin() + static_cast<std::ptrdiff_t>(length), bytes.end());
    if (checksum.text() != found || !visit(record, good + kLengthBytes)) break;
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
  const std::array<std::uint8_t, kLengthBytes> head = length_bytes(length);
  const std::string text = checksum.text();
  std::vector<std::span<const std::uint8_t>> record = {std::span(head)};
  record.insert(record.end(), parts.begin(), parts.end());
  record.emplace_back(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  file_.append(record);
}

}  // namespace multum
