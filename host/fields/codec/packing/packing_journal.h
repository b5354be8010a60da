// SPDX-License-Identifier: Apache-2.0
// Keeps the coded chunks of a packing in a hidden folder next to its output, so that a stopped packing can resume.
// Coding a chunk with the same lambda gives the same bytes.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "host/fields/codec/chunk_choice.h"
#include "host/foundation/base/files/record_file.h"

namespace multum {

/// Any number of threads may use a journal at once.
class PackingJournal {
 public:
  /// Opens the folder of the packing of `output`. `key` is one line that identifies everything on which the chunks
  /// depend. If `resume` is set, chunks with the same key are kept. All other chunks are removed. Returns null while
  /// another process packs to the same output. Throws Error(kEnvironment).
  static std::unique_ptr<PackingJournal> open(const std::string& output, const std::string& key, bool resume);
  PackingJournal(const PackingJournal&) = delete;
  PackingJournal& operator=(const PackingJournal&) = delete;

  /// Returns the chunk that an earlier run coded with this lambda.
  std::optional<ChosenChunk> find(std::size_t chunk, double lambda) const;
  /// Stores a coded chunk. Throws Error(kEnvironment).
  void add(std::size_t chunk, double lambda, const ChosenChunk& chosen);

  /// Keeps the folder when this object is destroyed, so that the stopped packing can resume.
  void leave() { journal_->leave(); }
  std::size_t found_count() const { return found_.size(); }

 private:
  PackingJournal() = default;

  std::unique_ptr<RecordJournal> journal_;
  std::map<std::pair<std::size_t, double>, ChosenChunk> found_;
};

}  // namespace multum
