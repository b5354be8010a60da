// SPDX-License-Identifier: Apache-2.0
// Keeps what a long piece of work has done in a file of the hidden folder beside its output, so that it goes on from
// there when it was stopped.
//
//   .multum-partial-NAME/FILE    a line that stands for sources and settings, then records: length (4 bytes,
//                                little-endian), bytes, checksum
//
// A record counts when it is whole and has its checksum, and so do all before it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "host/foundation/base/files/journal_file.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

/// Any number of threads may add to it at once.
class RecordJournal {
 public:
  /// A record, and where its bytes begin in the file. False: it is none of the kind, and no later one counts.
  using Visit = std::function<bool(std::span<const std::uint8_t> bytes, std::uint64_t offset)>;

  /// Of the work that makes `output`. `key`, a line, stands for everything that records depend on: those that are there
  /// of the same key are shown to `visit` and kept when `resume`, anything else is removed. Null while another process
  /// makes the same output. Throws Error(kEnvironment).
  static std::unique_ptr<RecordJournal> open(const std::string& output, const std::string& file, const std::string& key,
                                             bool resume, const Visit& visit);
  RecordJournal(const RecordJournal&) = delete;
  RecordJournal& operator=(const RecordJournal&) = delete;

  /// A record of these parts, one behind the other; less than 4 GiB. Throws Error(kEnvironment).
  void add(std::initializer_list<std::span<const std::uint8_t>> parts);
  /// Reads bytes of a record that `visit` was shown. False: they are not there any more.
  bool read(std::uint64_t offset, std::span<std::uint8_t> bytes) const { return file_.read(offset, bytes); }
  /// The folder stays when this is destroyed: the work was stopped and may go on.
  void leave() { folder_->leave(); }

 private:
  RecordJournal(std::unique_ptr<WorkFolder> folder, const std::string& file);
  /// Bytes of the file that count; 0 when it is of another key.
  std::uint64_t visit_records(const std::string& key, const Visit& visit) const;

  std::unique_ptr<WorkFolder> folder_;  // removed at the end, unless left
  JournalFile file_;
  std::mutex mutex_;  // of the file
};

}  // namespace multum
