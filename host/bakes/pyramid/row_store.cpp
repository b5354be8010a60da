// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/row_store.h"

#include <cstring>

#include "host/foundation/base/error.h"

namespace multum {

RowStore::RowStore(int row_count, std::size_t row_bytes, const SpillPolicy& spill)
    : row_count_(row_count), row_bytes_(row_bytes) {
  const std::size_t bytes = static_cast<std::size_t>(row_count) * row_bytes;
  if (bytes <= static_cast<std::uint64_t>(spill.memory_bytes)) memory_.resize(bytes);
  else file_.emplace(spill.scratch_folder);
}

RowStore::RowStore(int row_count, std::size_t row_bytes, const WorkFolder& folder, const std::string& name)
    : row_count_(row_count), row_bytes_(row_bytes), file_(ScratchFile(folder, name)) {}

std::size_t RowStore::range_begin(int first_row, int row_count) const {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && row_count <= row_count_ - first_row);
  return static_cast<std::size_t>(first_row) * row_bytes_;
}

void RowStore::write_bytes(std::size_t begin, const void* from, std::size_t byte_count) {
  if (file_) file_->write(begin, from, byte_count);
  else if (byte_count > 0) std::memcpy(memory_.data() + begin, from, byte_count);
}

void RowStore::read_bytes(std::size_t begin, void* to, std::size_t byte_count) const {
  if (file_) file_->read(begin, to, byte_count);
  else if (byte_count > 0) std::memcpy(to, memory_.data() + begin, byte_count);
}

void RowStore::write(int first_row, int row_count, const void* rows) {
  write_bytes(range_begin(first_row, row_count), rows, static_cast<std::size_t>(row_count) * row_bytes_);
}

void RowStore::read(int first_row, int row_count, void* rows) const {
  read_bytes(range_begin(first_row, row_count), rows, static_cast<std::size_t>(row_count) * row_bytes_);
}

void RowStore::write_beginning(int row, const void* bytes, std::size_t byte_count) {
  MULTUM_CHECK(byte_count <= row_bytes_);
  write_bytes(range_begin(row, 1), bytes, byte_count);
}

void RowStore::read_beginning(int row, void* bytes, std::size_t byte_count) const {
  MULTUM_CHECK(byte_count <= row_bytes_);
  read_bytes(range_begin(row, 1), bytes, byte_count);
}

}  // namespace multum
