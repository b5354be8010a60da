// SPDX-License-Identifier: Apache-2.0
// Builds box-filtered mip pyramids of any numeric planes, in bands of rows (kernels/mip_box.cl). Every texel of every
// level is the plain average of the finest texels that it covers. Only one sum per column is kept between bands.
//
//   for each band:  the caller fills nodes() with its planes' texels, then average(), then hand_over()
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/bakes/pyramid/row_blocks.h"
#include "host/formats/opencl/device.h"
#include "kernels/shared/mip_box.h"

namespace multum {

struct BoxMap {
  int width = 1;
  int height = 1;
  int plane_count = 1;
  int first_level = 0;  // the finest level to make
};

/// The rows of a level that a band has finished. They are valid only during the handover.
struct BoxRows {
  int level, first_row;
  int width, height;
  const float* first;  // one plane after another
  std::size_t plane_size, row_length;

  const float* row(int plane, int y) const {
    return first + static_cast<std::size_t>(plane) * plane_size + static_cast<std::size_t>(y) * row_length;
  }
};

/// The number of work-items per group. Groups of one work-item would be slow, because in PoCL starting a group takes as
/// long as running one of these small work-items.
constexpr std::size_t kBoxLocalSize = 64;

/// Throws Error(kInput) for a map that is too large, and Error(kUsage) for a first level that the map does not have.
void validate_box_map(int first_level, int map_width, int map_height);

class BoxPyramid {
 public:
  struct Memory {
    std::uint64_t bytes;            // memory for buffers; does not change the result
    std::size_t caller_row_values;  // floats that the caller needs per row of a band
  };

  /// Throws Error(kUsage) if there is too little memory for a row.
  BoxPyramid(Device& device, const BoxMap& map, const Memory& memory);

  int band_rows() const { return band_rows_; }
  std::uint64_t buffer_bytes() const;
  MultumBoxBand band(int first_row, int row_count) const;
  const DeviceBuffer& nodes() const { return nodes_; }
  /// Averages a band. Bands must be averaged in order from the top. Each band except the last has band_rows() rows.
  void average(const MultumBoxBand& band);
  /// Calls `consume` for every level with finished rows, the finest level first.
  void hand_over(const MultumBoxBand& band, const std::function<void(const BoxRows&)>& consume);

 private:
  int row_length() const;
  int column_count() const { return static_cast<int>(tap_begin_values_.size()) - 1; }
  std::uint64_t row_bytes() const;
  std::uint64_t fixed_bytes() const;
  int choose_band_rows() const;
  void make_columns();
  void make_buffers();

  Device& device_;
  const BoxMap map_;
  const Memory memory_;
  const RowBlocks blocks_;
  // The columns of all averaged levels, and the taps that each column has on a row.
  std::vector<MultumBoxLevel> level_values_;
  std::vector<int> level_numbers_;
  std::vector<int> tap_begin_values_;
  std::vector<MultumBoxTap> tap_values_;
  int band_rows_ = 1;
  DeviceBuffer nodes_, averages_, sums_, tap_begin_, taps_, levels_;
  Kernel sum_blocks_, sum_levels_;
};

}  // namespace multum
