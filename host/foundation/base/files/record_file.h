// SPDX-License-Identifier: Apache-2.0
// A file of records, in which a long piece of work keeps what it has done: for itself, when it goes on after a stop,
// and for other processes.
//
//   multum records 1      a line
//   KEY                   a line that stands for everything that the records depend on
//   record ...            length (8 bytes, little-endian), bytes, checksum of them (16 hexadecimal digits)
//
// A record counts when it is whole, and so do all before it: who goes on with a file cuts off what follows the last
// such one, which a kill or a full disk has torn.
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
  /// Of a record's bytes in the file.
  struct Place {
    std::uint64_t offset = 0, size = 0;
  };
  /// Bytes around those of a record.
  static constexpr std::uint64_t kHeadBytes = 8, kChecksumBytes = 16;

  static Bytes bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }

  /// Opens a file to be read. Throws Error(kEnvironment).
  explicit RecordFile(const std::string& path);
  /// A file that is written.
  explicit RecordFile(const AtomicFile& file);
  /// Open for what it is used for. `shown_path`: for messages.
  RecordFile(OpenFile file, std::string shown_path) : file_(std::move(file)), shown_path_(std::move(shown_path)) {}

  /// Calls `visit` with the places of the records, in order, until one does not count: the file ends before it does, or
  /// `visit` says false, as it does for those that read() finds damaged. Returns where the last one ends that counts; 0
  /// in a file of another key than `key`, of which null stands for any, and in one whose first lines are torn. Throws
  /// Error(kEnvironment) for a file of a former format, or of something else.
  std::uint64_t visit_records(const std::string* key, const std::function<bool(const Place&)>& visit) const;
  /// A record's bytes. False: they are not there, or do not have their checksum.
  bool read(const Place& place, std::vector<std::uint8_t>& bytes) const;
  /// Some of them, unchecked. False: they are not there.
  bool read(std::uint64_t offset, std::span<std::uint8_t> bytes) const;

  /// Empties the file and writes its first lines; or leaves `size` bytes of it, as visit_records() returns it. Then
  /// records may be added. Throw Error(kEnvironment).
  void begin(const std::string& key);
  void go_on(std::uint64_t size);
  /// A record of these parts, one behind the other. Any number of threads may add, and read, at once. Throws
  /// Error(kEnvironment) when the disk refuses: then nothing of it stays.
  Place add(std::initializer_list<Bytes> parts);

  const std::string& shown_path() const { return shown_path_; }

 private:
  void append(const std::vector<Bytes>& parts);

  OpenFile file_;
  std::string shown_path_;
  std::uint64_t size_ = 0;
  std::mutex mutex_;  // of appending
};

/// One in the hidden folder beside the output of the work, .multum-partial-NAME/FILE.
class RecordJournal : public RecordFile {
 public:
  /// `records` that are there of the same key are shown to `visit` and kept when `resume`, until it says false;
  /// anything else is removed. Null while another process makes the same output. Throws Error(kEnvironment), also for a
  /// file of a former format that is to be resumed.
  using Visit = std::function<bool(Bytes bytes, const Place& place)>;
  static std::unique_ptr<RecordJournal> open(const std::string& output, const std::string& file, const std::string& key,
                                             bool resume, const Visit& visit);

  /// The folder stays when this is destroyed: the work was stopped and may go on.
  void leave() { folder_->leave(); }

 private:
  RecordJournal(std::unique_ptr<WorkFolder> folder, const std::string& file);

  std::unique_ptr<WorkFolder> folder_;  // removed at the end, unless left
};

}  // namespace multum
