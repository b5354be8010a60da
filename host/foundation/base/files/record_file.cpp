// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/record_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/checksum.h"

namespace multum {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kFormatLine[] = "multum records 1\n";
constexpr std::size_t kFormatBytes = sizeof(kFormatLine) - 1, kKeyMax = 4096;

std::uint64_t size_of_file(const OpenFile& file, const std::string& path) {
  struct stat found {};
  if (!file.is_open() || ::fstat(file.descriptor(), &found) != 0) fail_by_errno(path, "cannot be opened");
  if (!S_ISREG(found.st_mode))
    throw Error(
        ErrorCode::kEnvironment,
        path +
            ": is not a file, but multum keeps the journal of interrupted work under this name; remove or rename it");
  return static_cast<std::uint64_t>(found.st_size);
}

bool write_all(int file, RecordFile::Bytes bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

// If the process was killed or the power failed, the file may hold only the beginning of the first line, or only zeros.
bool is_torn(const std::string& text) {
  return text[0] == '\0' || (text.size() < kFormatBytes && std::string(kFormatLine).starts_with(text));
}

}  // namespace

RecordFile::RecordFile(const std::string& path)
    : RecordFile(OpenFile(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)), path) {
  size_of_file(file_, shown_path_);
}

RecordFile::RecordFile(const AtomicFile& file)
    : RecordFile(OpenFile(::fcntl(file.descriptor(), F_DUPFD_CLOEXEC, 0)), file.path()) {}

std::uint64_t RecordFile::visit_records(const std::string* key, const std::function<bool(const Place&)>& visit) const {
  const std::uint64_t size = size_of_file(file_, shown_path_);
  std::string text(std::min<std::uint64_t>(size, kFormatBytes + kKeyMax), '\0');
  read(0, {reinterpret_cast<std::uint8_t*>(text.data()), text.size()});
  if (is_torn(text.substr(0, kFormatBytes))) return 0;
  if (!text.starts_with(kFormatLine))
    throw Error(ErrorCode::kEnvironment,
                shown_path_ +
                    ": its first line is not 'multum records 1', so another version of multum or another program wrote "
                    "it; delete it, or finish the interrupted work with the version that wrote it");
  const std::size_t key_end = text.find('\n', kFormatBytes);
  if (key_end == std::string::npos || (key != nullptr && text.substr(kFormatBytes, key_end - kFormatBytes) != *key))
    return 0;
  std::uint64_t end = key_end + 1;
  while (size - end >= kHeadBytes + kChecksumBytes) {
    Place place{end + kHeadBytes, 0};
    std::array<std::uint8_t, kHeadBytes> head{};
    if (!read(end, head)) break;
    std::memcpy(&place.size, head.data(), kHeadBytes);
    if (place.size > size - end - kHeadBytes - kChecksumBytes || !visit(place)) break;
    end = place.offset + place.size + kChecksumBytes;
  }
  return end;
}

bool RecordFile::read(const Place& place, std::vector<std::uint8_t>& bytes) const {
  bytes.resize(place.size + kChecksumBytes);
  if (!read(place.offset, bytes)) return false;
  Checksum checksum;
  checksum.update(bytes.data(), place.size);
  const bool is_whole = std::memcmp(checksum.text().data(), bytes.data() + place.size, kChecksumBytes) == 0;
  bytes.resize(place.size);
  return is_whole;
}

bool RecordFile::read(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file_.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

void RecordFile::begin(const std::string& key) {
  MULTUM_CHECK(key.size() < kKeyMax && key.find('\n') == std::string::npos);
  go_on(0);
  append({bytes_of(kFormatLine + key + "\n")});
}

void RecordFile::go_on(std::uint64_t size) {
  if (::ftruncate(file_.descriptor(), static_cast<off_t>(size)) != 0)
    fail_by_errno(shown_path_, "its damaged end cannot be removed");
  size_ = size;
}

RecordFile::Place RecordFile::add(std::initializer_list<Bytes> parts) {
  Place place;
  Checksum checksum;
  std::array<std::uint8_t, kHeadBytes> head{};
  std::vector<Bytes> record = {head};
  for (const Bytes& part : parts) {
    place.size += part.size();
    checksum.update(part.data(), part.size());
    record.push_back(part);
  }
  std::memcpy(head.data(), &place.size, kHeadBytes);
  const std::string text = checksum.text();
  record.push_back(bytes_of(text));
  const std::lock_guard lock(mutex_);
  place.offset = size_ + kHeadBytes;
  append(record);
  return place;
}

void RecordFile::append(const std::vector<Bytes>& parts) {
  std::uint64_t end = size_;
  for (const Bytes& part : parts) {
    if (!write_all(file_.descriptor(), part, end)) {
      const int error = errno;
      // If this also fails, the next run finds and removes the incomplete record at the end.
      [[maybe_unused]] const int ignored = ::ftruncate(file_.descriptor(), static_cast<off_t>(size_));
      errno = error;
      fail_by_errno(shown_path_, "cannot be written");
    }
    end += part.size();
  }
  size_ = end;
}

RecordJournal::RecordJournal(std::unique_ptr<WorkFolder> folder, const std::string& file)
    : RecordFile(OpenFile(::openat(folder->descriptor(), file.c_str(),
                                   O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600)),
                 folder->shown_path() + "/" + file),
      folder_(std::move(folder)) {}

std::unique_ptr<RecordJournal> RecordJournal::open(const std::string& output, const std::string& file,
                                                   const std::string& key, bool resume, const Visit& visit) {
  std::unique_ptr<WorkFolder> folder = WorkFolder::take(partial_folder_of(output));
  if (folder == nullptr) return nullptr;
  if (!resume) folder->clear();
  std::unique_ptr<RecordJournal> journal(new RecordJournal(std::move(folder), file));
  journal->folder_->leave();  // in case visit_records() throws
  std::vector<std::uint8_t> bytes;
  const std::uint64_t size = journal->visit_records(
      &key, [&](const Place& place) { return journal->read(place, bytes) && visit(bytes, place); });
  journal->folder_->leave(false);
  if (size > 0) {
    journal->go_on(size);
  } else {
    journal->folder_->clear(file);
    journal->begin(key);
  }
  return journal;
}

}  // namespace multum
