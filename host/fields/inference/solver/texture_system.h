// SPDX-License-Identifier: Apache-2.0
// Defines the linear system of texture inference on an OpenCL device (Hakura et al. 2000, section 3.2, eqs. 2-4, 6).
// The system has the stacked filter matrices of some views, with each row multiplied by the square root of its weight,
// and the derived matrices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/fields/inference/solver/inference_problem.h"
#include "host/fields/inference/solver/pyramid_tables.h"
#include "host/formats/asset/mip_layout.h"
#include "host/formats/opencl/device.h"

namespace multum {

/// Sparse rows in compressed form, in the host's memory.
struct SparseRows {
  std::vector<std::uint32_t> begin = {0};  // [rows + 1]
  std::vector<std::uint32_t> columns;
  std::vector<float> weights;
  std::size_t row_count() const { return begin.size() - 1; }
};

/// Appends the rows of `matrix` that have positive weights, each multiplied by the square root of its weight.
void append_weighted_rows(const InferenceView& view, SparseRows& rows);
SparseRows transposed(const SparseRows& rows, std::size_t column_count);
/// Computes A^T A from A and its transpose.
SparseRows normal_rows(const SparseRows& rows, const SparseRows& columns, int threads);

/// Estimates the number of entries of A^T A from the rows of evenly spaced texels.
std::size_t estimated_normal_entries(const SparseRows& rows, const SparseRows& columns);

/// Sparse rows on the device, in blocks of 8 entries (kernels/filter_matrix_spmv.cl).
class DeviceRows {
 public:
  DeviceRows() = default;
  DeviceRows(Device& device, const SparseRows& rows, const char* what);
  int row_count() const { return row_count_; }
  std::size_t byte_count() const;
  /// Computes y = rows * x.
  void multiply(Kernel& kernel, const DeviceBuffer& x, DeviceBuffer& y) const;

 private:
  DeviceBuffer block_begin_, columns_, weights_;
  int row_count_ = 0;
};

/// Three colours and a padding zero, as in the kernels.
using Colour4 = std::array<float, 4>;

class TextureSystem {
 public:
  TextureSystem(Device& device, const std::vector<InferenceView>& views, const InferenceSettings& settings,
                int threads);

  /// Computes sum = (A^T A + pyramid_weight R^T R) x.
  void apply(const DeviceBuffer& x, DeviceBuffer& sum);
  /// Returns A^T b, and the sums of b^2 by colour.
  std::vector<Colour4> projected(const std::vector<float>& colours, std::array<double, 3>* squares);
  std::vector<float> picture(const std::vector<float>& texels) const;
  /// Returns the total weight of each texel, which is the sum over rows of weight * A.
  const std::vector<float>& column_sums() const { return sums_; }

  std::size_t row_count() const { return rows_.row_count(); }
  DeviceBuffer make_texels(const char* what);

  Device& device;
  const InferenceSettings settings;
  MipLayout layout;
  bool is_periodic_s = false, is_periodic_t = false;
  bool uses_normal = false;
  double pyramid_weight = 0.0;  // weight that includes every factor of Gamma
  std::vector<float> diagonal;  // diagonal of A^T A + pyramid_weight R^T R
  std::size_t entry_count = 0, normal_entry_count = 0;
  Kernel curvature_product, advance_residual, advance_direction;

 private:
  void add_views(const std::vector<InferenceView>& views);
  bool has_pyramid() const { return pyramid_weight > 0.0 && layout.level_count() > 1; }
  void make_pyramid();

  SparseRows rows_;                  // rows times the square roots of their weights
  std::vector<float> root_weights_;  // one per row of every view; 0 for rows that are left out
  DeviceRows matrix_, transpose_, normal_;
  DeviceBuffer row_values_, residual_;
  DeviceBuffer levels_, taps_, gathers_, gather_entries_, strips_;  // pyramid_tables.h
  int strip_count_ = 0;
  Kernel spmv_, pyramid_residual_, pyramid_gradient_;
  std::vector<float> sums_;
};

}  // namespace multum
