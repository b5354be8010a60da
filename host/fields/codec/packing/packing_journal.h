// SPDX-License-Identifier: Apache-2.0
// Keeps the chunks that a packing has coded in a hidden folder beside its output, so that one that was stopped is
// resumed: what was coded for a lambda is coded the same again.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "host/fields/codec/chunk_choice.h"
#include "host/foundation/base/files/record_file.h"

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
  void leave() { journal_->leave(); }
  std::size_t found_count() const { return found_.size(); }

 private:
  PackingJournal() = default;

  std::unique_ptr<RecordJournal> journal_;
  std::map<std::pair<std::size_t, double>, ChosenChunk> found_;
};

}  // namespace multum
