// SPDX-License-Identifier: Apache-2.0
// Stores rows of equal size in memory or in a scratch file. The rows are the output of one level of a pyramid and the
// input of the next level.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/files/scratch_file.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

class RowStore {
 public:
  RowStore(int row_count, std::size_t row_bytes, const SpillPolicy& spill);
  /// Uses the file `name` in `folder`, where an earlier process may have left rows.
  RowStore(int row_count, std::size_t row_bytes, const WorkFolder& folder, const std::string& name);

  int row_count() const { return row_count_; }
  std::size_t row_bytes() const { return row_bytes_; }
  /// Writes rows [first_row, first_row + row_count). Throws Error(kEnvironment) for errors of the disk.
  void write(int first_row, int row_count, const void* rows);
  void read(int first_row, int row_count, void* rows) const;
  /// Writes the first `byte_count` bytes of a row. The rest takes no disk space.
  void write_beginning(int row, const void* bytes, std::size_t byte_count);
  void read_beginning(int row, void* bytes, std::size_t byte_count) const;

 private:
  std::size_t range_begin(int first_row, int row_count) const;
  void write_bytes(std::size_t begin, const void* from, std::size_t byte_count);
  void read_bytes(std::size_t begin, void* to, std::size_t byte_count) const;

  int row_count_;
  std::size_t row_bytes_;
  std::vector<unsigned char> memory_;
  std::optional<ScratchFile> file_;
};

}  // namespace multum
