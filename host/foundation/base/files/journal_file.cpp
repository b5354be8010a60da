// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/journal_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::size_t kLineWindow = 4096;  // bytes that are read at once in search of a line's end

bool write_all(int file, std::span<const std::uint8_t> bytes, std::uint64_t offset) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

JournalFile::JournalFile(const WorkFolder& folder, const std::string& name)
    : shown_path_(folder.shown_path() + "/" + name),
      file_(::openat(folder.descriptor(), name.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600)) {
  struct stat found {};
  if (!file_.is_open() || ::fstat(file_.descriptor(), &found) != 0) fail_by_errno(shown_path_, "cannot be opened");
  if (!S_ISREG(found.st_mode))
    throw Error(ErrorCode::kEnvironment, shown_path_ + ": is no file, expected a journal of stopped work; remove it");
  size_ = static_cast<std::uint64_t>(found.st_size);
}

bool JournalFile::read(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  if (offset > size_ || bytes.size() > size_ - offset) return false;
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file_.descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    bytes = bytes.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

std::optional<std::string> JournalFile::line(std::uint64_t offset, std::size_t length_max) const {
  std::string text;
  while (text.size() <= length_max && offset + text.size() < size_) {
    const std::size_t begin = text.size();
    text.resize(begin + std::min<std::uint64_t>(kLineWindow, size_ - offset - begin));
    if (!read(offset + begin, {reinterpret_cast<std::uint8_t*>(text.data()) + begin, text.size() - begin})) return {};
    if (const std::size_t end = text.find('\n', begin); end != std::string::npos)
      return end <= length_max ? std::optional(text.substr(0, end)) : std::nullopt;
  }
  return {};
}

void JournalFile::cut(std::uint64_t size) {
  if (size == size_) return;
  if (::ftruncate(file_.descriptor(), static_cast<off_t>(size)) != 0)
    fail_by_errno(shown_path_, "its damaged end cannot be cut off");
  size_ = size;
}

void JournalFile::append(std::span<const std::span<const std::uint8_t>> parts) {
  std::uint64_t end = size_;
  for (const auto& part : parts) {
    if (!write_all(file_.descriptor(), part, end)) {
      const int error = errno;
      // Where this fails too, the next run finds a torn end and cuts it.
      [[maybe_unused]] const int ignored = ::ftruncate(file_.descriptor(), static_cast<off_t>(size_));
      errno = error;
      fail_by_errno(shown_path_, "cannot be written");
    }
    end += part.size();
  }
  size_ = end;
}

void JournalFile::append_line(const std::string& line) {
  const std::string text = line + "\n";
  const std::span<const std::uint8_t> bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  append({&bytes, 1});
}

}  // namespace multum
