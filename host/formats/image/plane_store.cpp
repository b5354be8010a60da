// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/plane_store.h"

#include <algorithm>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {

PlaneStore::PlaneStore(int width, int height) : width_(width), height_(height) {
  for (std::size_t p = 0; p < 3; ++p) {
    owned_[p] = std::make_unique_for_overwrite<float[]>(offset(height));
    prefer_large_pages(owned_[p].get(), offset(height) * sizeof(float));
    planes_[p] = owned_[p].get();
  }
}

PlaneStore::PlaneStore(int width, int height, const std::string& folder)
    : width_(width), height_(height), file_(ScratchFile(folder)) {}

PlaneStore::PlaneStore(int width, int height, ScratchFile file, const PlaneBlocks& blocks)
    : width_(width), height_(height), file_(std::move(file)), blocks_(blocks) {}

PlaneStore::PlaneStore(int width, int height, const std::array<const float*, 3>& planes)
    : width_(width), height_(height), planes_(planes) {}

std::array<std::vector<float>, 3> PlaneStore::take_planes() {
  MULTUM_CHECK(!file_ && planes_[0] == owned_[0].get());
  std::array<std::vector<float>, 3> planes;
  for (std::size_t p = 0; p < 3; ++p) {
    planes[p].assign(planes_[p], planes_[p] + offset(height_));
    owned_[p].reset();
  }
  height_ = 0;
  return planes;
}

std::uint64_t PlaneStore::offset_in_file(int plane, int row) const {
  const int rows = blocks_.rows > 0 ? blocks_.rows : height_, blocks = (height_ + rows - 1) / rows;
  return blocks_.begin + (static_cast<std::uint64_t>(plane) * offset(height_) + offset(row)) * sizeof(float) +
         static_cast<std::uint64_t>(plane * blocks + row / rows) * blocks_.gap;
}

void PlaneStore::check_rows(int first_row, int row_count) const {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && row_count <= height_ - first_row);
}

void PlaneStore::write_rows(int first_row, int row_count, const std::array<const float*, 3>& planes) {
  check_rows(first_row, row_count);
  const std::size_t count = offset(row_count);
  for (std::size_t p = 0; p < 3; ++p) {
    if (file_) {
      file_->write(offset_in_file(static_cast<int>(p), first_row), planes[p], count * sizeof(float));
    } else {
      MULTUM_CHECK(planes_[p] == owned_[p].get());
      std::copy_n(planes[p], count, owned_[p].get() + offset(first_row));
    }
  }
}

void PlaneStore::read_rows(int first_row, int row_count, const std::array<float*, 3>& planes) const {
  for (int p = 0; p < 3; ++p) read_rows(p, first_row, row_count, planes[static_cast<std::size_t>(p)]);
}

void PlaneStore::read_rows(int plane, int first_row, int row_count, float* rows) const {
  check_rows(first_row, row_count);
  const auto p = static_cast<std::size_t>(plane);
  if (!file_) {
    std::copy_n(planes_[p] + offset(first_row), offset(row_count), rows);
    return;
  }
  const int block = blocks_.rows > 0 ? blocks_.rows : height_;
  for (int row = first_row; row < first_row + row_count;) {
    const int count = std::min(first_row + row_count - row, block - row % block);
    file_->read(offset_in_file(plane, row), rows + offset(row - first_row), offset(count) * sizeof(float));
    row += count;
  }
}

std::array<float, 3> PlaneStore::texel(int column, int row) const {
  check_rows(row, 1);
  const std::size_t at = offset(row) + static_cast<std::size_t>(column);
  std::array<float, 3> values{};
  for (std::size_t p = 0; p < 3; ++p) {
    if (file_)
      file_->read(offset_in_file(static_cast<int>(p), row) + static_cast<std::size_t>(column) * sizeof(float),
                  &values[p], sizeof(float));
    else values[p] = planes_[p][at];
  }
  return values;
}

PlaneStore make_plane_store(int width, int height, const SpillPolicy& spill) {
  const std::int64_t byte_count = std::int64_t{width} * height * 3 * static_cast<std::int64_t>(sizeof(float));
  return byte_count <= spill.memory_bytes ? PlaneStore(width, height) : PlaneStore(width, height, spill.scratch_folder);
}

int decoding_rows(int width, const SpillPolicy& spill) {
  if (spill.band_rows > 0) return spill.band_rows;
  constexpr int kTexels = 1 << 17, kRowsMin = 4, kRowsMax = 64;
  return std::clamp(kTexels / width, kRowsMin, kRowsMax);
}

}  // namespace multum
