// SPDX-License-Identifier: Apache-2.0
// Stores the results of a long task as records, so that interrupted work can be resumed and other processes can read
// the results.
//
//   multum records 1      a line
//   KEY                   a line that identifies everything that the records depend on
//   record ...            length (8 bytes, little-endian), bytes, checksum of the bytes (16 hexadecimal digits)
//
// A record is valid if it and all records before it are complete. A process that resumes the file cuts off everything
// after the last valid record. An incomplete record remains if the process was killed, or the disk was full, while the
// record was being written.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

class RecordFile {
 public:
  using Bytes = std::span<const std::uint8_t>;
  /// The position of a record's bytes in the file.
  struct Place {
    std::uint64_t offset = 0, size = 0;
  };
  /// The numbers of bytes that a record has before and after its contents.
  static constexpr std::uint64_t kHeadBytes = 8, kChecksumBytes = 16;

  static Bytes bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }

  /// Opens a file for reading. Throws Error(kEnvironment).
  explicit RecordFile(const std::string& path);
  /// Uses a file that is being written.
  explicit RecordFile(const AtomicFile& file);
  /// Uses an open file. Reads or writes according to the mode in which it was opened. Messages show `shown_path`.
  RecordFile(OpenFile file, std::string shown_path) : file_(std::move(file)), shown_path_(std::move(shown_path)) {}

  /// Calls `visit` with the places of the records, in order, until the file ends within a record or `visit` returns
  /// false. `visit` must return false for a record that read() finds damaged. Returns the end of the last valid record.
  /// Returns 0 if the first lines are incomplete or the file has another key. A null `key` accepts any key. Throws
  /// Error(kEnvironment) for an earlier format or another kind of file.
  std::uint64_t visit_records(const std::string* key, const std::function<bool(const Place&)>& visit) const;
  /// Reads a record's bytes. Returns false if they are missing or do not match their checksum.
  bool read(const Place& place, std::vector<std::uint8_t>& bytes) const;
  /// Reads bytes at `offset` without checking them. Returns false if they are missing.
  bool read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;

  /// begin() empties the file and writes its first lines. go_on() keeps the first `size` bytes of the file, where
  /// `size` is the result of visit_records(). Records may be added afterwards. Both functions throw
  /// Error(kEnvironment).
  void begin(const std::string& key);
  void go_on(std::uint64_t size);
  /// Appends a record that consists of these parts in order. Any number of threads may append and read at once. Throws
  /// Error(kEnvironment) if the disk fails. In this case, no part of the record remains.
  Place add(std::initializer_list<Bytes> parts);

  const std::string& shown_path() const { return shown_path_; }

 private:
  void append(const std::vector<Bytes>& parts);

  OpenFile file_;
  std::string shown_path_;
  std::uint64_t size_ = 0;
  std::mutex mutex_;  // locked while a record is appended
};

/// A record file in the hidden folder next to the output of the work, .multum-partial-NAME/FILE.
class RecordJournal : public RecordFile {
 public:
  /// With `resume`, passes the existing records of the same key to `visit`, one by one, and keeps them until `visit`
  /// returns false. Removes all other records. Returns null if another process is making the same output. Throws
  /// Error(kEnvironment), also if the file to resume has an earlier format.
  using Visit = std::function<bool(Bytes bytes, const Place& place)>;
  static std::unique_ptr<RecordJournal> open(const std::string& output, const std::string& file, const std::string& key,
                                             bool resume, const Visit& visit);

  /// Keeps the folder when this object is destroyed, so that interrupted work can be resumed.
  void leave() { folder_->leave(); }

 private:
  RecordJournal(std::unique_ptr<WorkFolder> folder, const std::string& file);

  std::unique_ptr<WorkFolder> folder_;  // removed at the end, unless leave() was called
};

}  // namespace multum
