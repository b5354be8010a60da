// SPDX-License-Identifier: Apache-2.0
// Keeps the chunks that a packing has coded in a hidden folder beside its output, so that one that was stopped is
// resumed: what was coded for a lambda is coded the same again.
//
//   .multum-partial-NAME/
//     chunks     a line that stands for sources and settings, then records: length (4 bytes), chunk, checksum
//
// A record counts when it is whole and has its checksum, and so do all before it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "host/base/files/partial_folder.h"
#include "host/codec/chunk_choice.h"

namespace multum {

/// Any number of threads may use it at once.
class PackingJournal {
 public:
  /// Opens the folder of the packing of `output`; `key`, a line, stands for everything that its chunks depend on. What
  /// is there of the same key is kept when `resume`, anything else is removed. Null while another process packs to the
  /// same output. Throws Error(kEnvironment).
  static std::unique_ptr<PackingJournal> open(const std::string& output, const std::string& key, bool resume);
  PackingJournal(const PackingJournal&) = delete;
  PackingJournal& operator=(const PackingJournal&) = delete;

  /// What an earlier run coded of a chunk for this lambda.
  std::optional<ChosenChunk> find(std::size_t chunk, double lambda) const;
  /// Makes a note of it. Throws Error(kEnvironment).
  void add(std::size_t chunk, double lambda, const ChosenChunk& chosen);

  /// The folder stays when this is destroyed: the packing was stopped and may go on.
  void leave() { folder_->leave(); }
  std::size_t found_count() const { return found_.size(); }

 private:
  PackingJournal(std::unique_ptr<PartialFolder> folder, const std::string& key, bool resume);
  std::string chunks_path() const { return folder_->path() + "/chunks"; }
  /// Bytes of the file that count; 0 when it is of another key.
  std::uint64_t read_chunks(const std::string& key);

  std::unique_ptr<PartialFolder> folder_;  // removed at the end, unless left
  std::map<std::pair<std::size_t, double>, ChosenChunk> found_;
  std::mutex mutex_;  // of the file
};

}  // namespace multum
