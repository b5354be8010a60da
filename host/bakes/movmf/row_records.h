// SPDX-License-Identifier: Apache-2.0
// Stores rows of levels in record files (host/foundation/base/files/record_file.h). Such rows belong to a killed bake
// or to a share of a map.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/foundation/base/files/record_file.h"

namespace multum {

/// The parts of a row are lobes from which finer levels grow, [lobe][column]; features, [triple][lobe][column]; and, if
/// they differ from the first lobes, lobes for the file.
enum class RowPart { kLobes, kFeatures, kStored };

/// The bytes per row of each part, or 0 if the part is missing.
using RowBytes = std::array<std::uint64_t, 3>;

/// Header of a record of rows. The rows of each part follow it.
struct RowBlock {
  std::int32_t level = 0, first_row = 0, row_count = 0, unused = 0;
  RowBytes row_bytes{};
};

/// Holds rows from any number of files, which must outlive the object.
class RowRecords {
 public:
  /// Appends rows to a file, in records of a few megabytes, because reading a row loads its whole record. Parts that
  /// are missing may be null. Throws Error(kEnvironment).
  void add(RecordFile& file, const RowBlock& rows, const std::array<const void*, 3>& parts);
  /// Adds an existing record without reading its rows. `remedy` is advice for damaged rows, or null. It must outlive
  /// the object. Returns false if the record holds no rows.
  bool take(const RecordFile& file, const RecordFile::Place& place, const std::string* remedy = nullptr);

  /// Returns the number of consecutive rows of a level, beginning with row 0, that have this size, and drops all other
  /// rows. Call this function once per level, before rows are added.
  int row_count(int level, const RowBytes& row_bytes);
  /// Returns the position of the rows in the first record of a level, or 0 if there is none.
  std::uint64_t begin_of(int level) const;
  /// Reads rows. Reading in order is fastest. If there are no separate lobes for the file, kStored reads the lobes of
  /// kLobes. Throws Error(kEnvironment) for rows that are missing or damaged.
  void read(int level, RowPart part, int first_row, int row_count, void* rows);

 private:
  struct Found {
    RowBlock rows;
    const RecordFile* file;
    RecordFile::Place place;
    const std::string* remedy;
  };
  const Found& load(int level, int row);

  std::map<int, std::vector<Found>> found_;  // [level], in order
  // The last record that was read.
  const RecordFile* file_ = nullptr;
  std::uint64_t place_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace multum
