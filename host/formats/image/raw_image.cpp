// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/raw_image.h"

#include <cstring>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {

RawImage::RawImage(RawImageInfo info, const SpillPolicy& spill) : info_(std::move(info)), converter_(info_.base_type) {
  const std::size_t byte_count = info_.row_bytes * static_cast<std::size_t>(info_.height);
  if (static_cast<std::int64_t>(byte_count) > spill.memory_bytes) {
    file_.emplace(spill.scratch_folder);
  } else {
    samples_ = std::make_unique_for_overwrite<std::byte[]>(byte_count);
    prefer_large_pages(samples_.get(), byte_count);
  }
}

void RawImage::write(const RawBand& band) {
  MULTUM_CHECK(band.first_row >= 0 && band.row_count <= info_.height - band.first_row);
  const std::size_t offset = info_.row_bytes * static_cast<std::size_t>(band.first_row);
  const std::size_t byte_count = info_.row_bytes * static_cast<std::size_t>(band.row_count);
  if (file_) {
    file_->write(offset, band.samples, byte_count);
  } else {
    std::memcpy(samples_.get() + offset, band.samples, byte_count);
  }
}

void RawImage::read_rows(int first_row, int row_count, RawRows& rows) const {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && row_count <= info_.height - first_row);
  const std::size_t offset = info_.row_bytes * static_cast<std::size_t>(first_row);
  const std::size_t value_count = info_.row_values() * static_cast<std::size_t>(row_count);
  rows.values.resize(value_count);
  if (file_) {
    rows.samples.resize(info_.row_bytes * static_cast<std::size_t>(row_count));
    file_->read(offset, rows.samples.data(), rows.samples.size());
  }
  const std::byte* samples = file_ ? rows.samples.data() : samples_.get() + offset;
  converter_.convert(samples, value_count, rows.values.data());
}

}  // namespace multum
