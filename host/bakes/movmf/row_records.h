// SPDX-License-Identifier: Apache-2.0
// Keeps rows of levels in files of records (host/foundation/base/files/record_file.h): those that a killed bake had
// done, and those of a share of a map.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/foundation/base/files/record_file.h"

namespace multum {

/// What rows hold: lobes that finer levels grow from, [lobe][column]; features, [triple][lobe][column]; and lobes as
/// the file stores them, where they are not the first.
enum class RowPart { kLobes, kFeatures, kStored };

/// Bytes of a row of each part; 0: there is none.
using RowBytes = std::array<std::uint64_t, 3>;

/// What a record of rows begins with; the rows of each part follow.
struct RowBlock {
  std::int32_t level = 0, first_row = 0, row_count = 0, unused = 0;
  RowBytes row_bytes{};
};

/// Rows of any number of files, which outlive it.
class RowRecords {
 public:
  /// Appends rows to a file, in records of some megabytes: whoever reads a row holds its record. `parts` may be null
  /// where there are none. Throws Error(kEnvironment).
  void add(RecordFile& file, const RowBlock& rows, const std::array<const void*, 3>& parts);
  /// Takes a record that is there; its rows are not looked at. `remedy`: what to do where they are damaged, which
  /// outlives this; null: nothing. False: the record is none of rows.
  bool take(const RecordFile& file, const RecordFile::Place& place, const std::string* remedy = nullptr);

  /// How many rows of a level there are from row 0 on, of so many bytes; others that there may be are forgotten. Once
  /// for a level, before rows are added to it while others are read.
  int row_count(int level, const RowBytes& row_bytes);
  /// Where the first record of a level has its rows; nothing: 0.
  std::uint64_t begin_of(int level) const;
  /// Quick where rows are read in order. Stored lobes are the others where there are none of their own. Throws
  /// Error(kEnvironment) for rows that are missing or damaged.
  void read(int level, RowPart part, int first_row, int row_count, void* rows);

 private:
  struct Found {
    RowBlock rows;
    const RecordFile* file;
    RecordFile::Place place;
    const std::string* remedy;
  };
  const Found& load(int level, int row);

  std::map<int, std::vector<Found>> found_;  // by level, in order
  // Of the record that was read last.
  const RecordFile* file_ = nullptr;
  std::uint64_t place_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace multum
