// SPDX-License-Identifier: Apache-2.0
// Keeps the fitted rows of an export in a hidden folder next to its output, so that a stopped export can resume. Only
// fits are kept, because they take most of the time. The averages of the map are computed again.
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
  /// Opens the journal of the export to `output`. `key` is one line that identifies everything on which fits depend.
  /// Keeps rows with the same key and removes all other rows. Returns null if another process is exporting to the same
  /// output. Throws Error(kEnvironment).
  static std::unique_ptr<FitJournal> open(const std::string& output, const std::string& key);
  FitJournal(const FitJournal&) = delete;
  FitJournal& operator=(const FitJournal&) = delete;

  /// Fills `fitted` with all planes of these rows if an earlier run stored exactly these rows. Otherwise returns false.
  bool find(int level, int first_row, int width, int height, std::vector<float>& fitted);
  /// Throws Error(kEnvironment).
  void add(int level, int first_row, int width, int height, const std::vector<float>& fitted);

  /// Keeps the folder when this object is destroyed, so that the stopped export can resume.
  void leave() { journal_->leave(); }
  /// Returns the number of rows that find() has found.
  std::uint64_t rows_resumed() const { return rows_resumed_; }

 private:
  // The position of a record's floats in the file.
  struct Place {
    std::uint64_t offset;
    std::uint32_t width, height;
  };

  FitJournal() = default;

  std::unique_ptr<RecordJournal> journal_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Place> found_;  // places by level and first row
  std::uint64_t rows_resumed_ = 0;
};

}  // namespace multum
