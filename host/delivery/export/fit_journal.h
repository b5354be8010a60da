// SPDX-License-Identifier: Apache-2.0
// Keeps the rows that an export has fitted in a hidden folder beside its output, so that one that was stopped is
// resumed. Averages of the map are made anew: fits take most of the time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/foundation/base/files/record_file.h"

namespace multum {

class FitJournal {
 public:
  /// Of the export of `output`; `key`, a line, stands for everything that fits depend on. Rows of the same key are
  /// kept, anything else is removed. Null while another process exports to the same output. Throws
  /// Error(kEnvironment).
  static std::unique_ptr<FitJournal> open(const std::string& output, const std::string& key);
  FitJournal(const FitJournal&) = delete;
  FitJournal& operator=(const FitJournal&) = delete;

  /// Fills `fitted`, all planes of so many rows of a level, with what a run before this one has added of just these.
  /// False: there is none.
  bool find(int level, int first_row, int width, int height, std::vector<float>& fitted);
  /// Throws Error(kEnvironment).
  void add(int level, int first_row, int width, int height, const std::vector<float>& fitted);

  /// The folder stays when this is destroyed: the export was stopped and may go on.
  void leave() { journal_->leave(); }
  /// Rows that find() has found.
  std::uint64_t rows_resumed() const { return rows_resumed_; }

 private:
  // Of a record's floats.
  struct Place {
    std::uint64_t offset;
    std::uint32_t width, height;
  };

  FitJournal() = default;

  std::unique_ptr<RecordJournal> journal_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Place> found_;  // by level and first row
  std::uint64_t rows_resumed_ = 0;
};

}  // namespace multum
