// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/averages/sh_mipmap.h"

#include "host/formats/asset/half_value.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {

std::vector<ShLevel> empty_sh_levels(int width, int height) {
  std::vector<ShLevel> levels;
  for (int l = 0; l < mip_level_count(width, height); ++l)
    levels.push_back({mip_level_size(width, l), mip_level_size(height, l), {}, {}, {}});
  return levels;
}

ShLevel rows_of(const ShLevel& level, int first_row, int row_count) {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= level.height);
  const auto width = static_cast<std::size_t>(level.width), begin = static_cast<std::size_t>(first_row) * width;
  const auto of_rows = [&](const auto& values) {
    return texels_of(values, width * static_cast<std::size_t>(level.height), begin,
                     begin + width * static_cast<std::size_t>(row_count));
  };
  ShLevel rows{level.width, row_count, {}, of_rows(level.colours), of_rows(level.weights)};
  for (const std::vector<glm::vec4>& part : level.parts) rows.parts.push_back(of_rows(part));
  return rows;
}

void quantize_sh(ShLevel& rows, StorageEncoding encoding, int threads) {
  MULTUM_CHECK(encoding != StorageEncoding::kSnorm16);
  if (encoding == StorageEncoding::kFloat) return;
  const auto width = static_cast<std::size_t>(rows.width);
  for_each_row_band(rows.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (std::size_t i = static_cast<std::size_t>(row_begin) * width; i < static_cast<std::size_t>(row_end) * width;
         ++i) {
      for (std::vector<glm::vec4>& part : rows.parts)
        for (int c = 0; c < 4; ++c) part[i][c] = as_half(part[i][c]);
      if (!rows.colours.empty())
        for (int c = 0; c < 3; ++c) rows.colours[i][c] = as_half(rows.colours[i][c]);
    }
    const std::size_t weight_row = rows.weights.size() / static_cast<std::size_t>(rows.height);
    for (std::size_t i = static_cast<std::size_t>(row_begin) * weight_row;
         i < static_cast<std::size_t>(row_end) * weight_row; ++i)
      rows.weights[i] = as_half(rows.weights[i]);
  });
}

// With 16-bit floats, rounding changes each coefficient by at most 2^-11 of its value, and its square by at most 2^-10.
// With 32-bit floats, the second value covers the errors of the basis (4e-6 of its bound) and of each averaging step
// (about 2^-24).
double sh_power_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 1e-3 : 2e-5; }

}  // namespace multum
