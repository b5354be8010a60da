// SPDX-License-Identifier: Apache-2.0
#include "host/image/plane_store.h"

#include <algorithm>

#include "host/base/error.h"

namespace multum {

PlaneStore::PlaneStore(int width, int height) : width_(width), height_(height) {
  for (std::size_t p = 0; p < 3; ++p) {
    owned_[p].resize(offset(height));
    planes_[p] = owned_[p].data();
  }
}

PlaneStore::PlaneStore(int width, int height, const std::string& folder)
    : width_(width), height_(height), file_(ScratchFile(folder)) {}

PlaneStore::PlaneStore(int width, int height, const std::array<const float*, 3>& planes)
    : width_(width), height_(height), planes_(planes) {}

void PlaneStore::check_rows(int first_row, int row_count) const {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && row_count <= height_ - first_row);
}

void PlaneStore::write_rows(int first_row, int row_count, const std::array<const float*, 3>& planes) {
  check_rows(first_row, row_count);
  const std::size_t count = offset(row_count);
  for (std::size_t p = 0; p < 3; ++p) {
    if (file_) {
      file_->write((p * offset(height_) + offset(first_row)) * sizeof(float), planes[p], count * sizeof(float));
    } else {
      MULTUM_CHECK(planes_[p] == owned_[p].data());
      std::copy_n(planes[p], count, owned_[p].begin() + static_cast<std::ptrdiff_t>(offset(first_row)));
    }
  }
}

void PlaneStore::read_rows(int first_row, int row_count, const std::array<float*, 3>& planes) const {
  check_rows(first_row, row_count);
  const std::size_t count = offset(row_count);
  for (std::size_t p = 0; p < 3; ++p) {
    if (file_) file_->read((p * offset(height_) + offset(first_row)) * sizeof(float), planes[p], count * sizeof(float));
    else std::copy_n(planes_[p] + offset(first_row), count, planes[p]);
  }
}

}  // namespace multum
