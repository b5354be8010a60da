// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/solver/texture_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

// The largest ratio of entries of A^T A to entries of A for which A^T A is used. An iteration passes once over A and
// once over its transpose, but only once over A^T A. Both ways take about the same time near a ratio of 3. (In
// docs/evidence/BENCHMARKS.md, an iteration with A^T A takes half of the time at 2.2, and about the same time at 3.3
// and 3.8.) But computing A^T A also takes time. It takes as long as 20 iterations save if pictures are stacked, and as
// long as 90 iterations save at a ratio of 2.2. The limit of 2 excludes ratios that rarely save time. The paper's rule,
// 2 n_s >= 4 n_t, assumes eight entries per row.
constexpr std::size_t kNormalEntriesMax = 2;
constexpr int kEntriesOfBlock = 8;
constexpr std::size_t kRowsAnItem = 256;  // work-items per group of the products

template <typename Element>
DeviceBuffer uploaded(Device& device, const std::vector<Element>& list, const char* what) {
  DeviceBuffer buffer = device.make_buffer(list.size() * sizeof(Element), what);
  device.write(buffer, list.data(), buffer.byte_count());
  return buffer;
}

}  // namespace

void append_weighted_rows(const InferenceView& view, SparseRows& rows) {
  const FilterMatrix& m = *view.matrix;
  for (std::size_t r = 0; r < m.row_count(); ++r) {
    const float root = std::sqrt(view.row_weights[r]);
    if (!(root > 0.0f)) continue;
    for (std::uint32_t i = m.row_begin[r]; i < m.row_begin[r + 1]; ++i) {
      rows.columns.push_back(m.columns[i]);
      rows.weights.push_back(root * m.weights[i]);
    }
    rows.begin.push_back(static_cast<std::uint32_t>(rows.columns.size()));
  }
}

SparseRows transposed(const SparseRows& rows, std::size_t column_count) {
  SparseRows result;
  result.begin.assign(column_count + 1, 0);
  for (const std::uint32_t column : rows.columns) ++result.begin[column + 1];
  for (std::size_t c = 0; c < column_count; ++c) result.begin[c + 1] += result.begin[c];
  result.columns.resize(rows.columns.size());
  result.weights.resize(rows.weights.size());
  std::vector<std::uint32_t> place(result.begin.begin(), result.begin.end() - 1);
  for (std::size_t r = 0; r < rows.row_count(); ++r)
    for (std::uint32_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i) {
      const std::uint32_t to = place[rows.columns[i]]++;
      result.columns[to] = static_cast<std::uint32_t>(r);
      result.weights[to] = rows.weights[i];
    }
  return result;
}

SparseRows normal_rows(const SparseRows& rows, const SparseRows& columns, int threads) {
  const auto texel_count = static_cast<int>(columns.row_count());
  constexpr int kTexelsABand = 1024;
  struct Band {
    std::vector<std::uint32_t> sizes, columns;
    std::vector<float> weights;
  };
  std::vector<Band> bands(static_cast<std::size_t>(row_band_count(texel_count, kTexelsABand)));
  for_each_row_band(texel_count, kTexelsABand, threads, [&](int number, int begin, int end) {
    Band& band = bands[static_cast<std::size_t>(number)];
    std::vector<double> sums(static_cast<std::size_t>(texel_count), 0.0);
    std::vector<bool> is_met(static_cast<std::size_t>(texel_count), false);
    std::vector<std::uint32_t> met;
    for (int t = begin; t < end; ++t) {
      met.clear();
      const auto texel = static_cast<std::size_t>(t);
      for (std::uint32_t i = columns.begin[texel]; i < columns.begin[texel + 1]; ++i) {
        const std::uint32_t row = columns.columns[i];
        for (std::uint32_t k = rows.begin[row]; k < rows.begin[row + 1]; ++k) {
          const std::uint32_t other = rows.columns[k];
          if (!is_met[other]) {
            is_met[other] = true;
            met.push_back(other);
          }
          sums[other] += static_cast<double>(columns.weights[i]) * static_cast<double>(rows.weights[k]);
        }
      }
      std::sort(met.begin(), met.end());
      for (const std::uint32_t other : met) {
        band.columns.push_back(other);
        band.weights.push_back(static_cast<float>(sums[other]));
        sums[other] = 0.0;
        is_met[other] = false;
      }
      band.sizes.push_back(static_cast<std::uint32_t>(met.size()));
    }
  });
  SparseRows result;
  for (const Band& band : bands) {
    for (const std::uint32_t size : band.sizes) result.begin.push_back(result.begin.back() + size);
    result.columns.insert(result.columns.end(), band.columns.begin(), band.columns.end());
    result.weights.insert(result.weights.end(), band.weights.begin(), band.weights.end());
  }
  return result;
}

std::size_t estimated_normal_entries(const SparseRows& rows, const SparseRows& columns) {
  constexpr std::size_t kSamples = 512;
  std::vector<std::uint32_t> seen;
  for (std::size_t t = 0; t < columns.row_count(); ++t)
    if (columns.begin[t] < columns.begin[t + 1]) seen.push_back(static_cast<std::uint32_t>(t));
  if (seen.empty()) return 0;
  const std::size_t step = std::max<std::size_t>(1, seen.size() / kSamples);
  std::size_t entries = 0, samples = 0;
  std::vector<std::uint32_t> met;
  for (std::size_t s = 0; s < seen.size(); s += step, ++samples) {
    met.clear();
    for (std::uint32_t i = columns.begin[seen[s]]; i < columns.begin[seen[s] + 1]; ++i) {
      const std::uint32_t row = columns.columns[i];
      met.insert(met.end(), rows.columns.begin() + rows.begin[row], rows.columns.begin() + rows.begin[row + 1]);
    }
    std::sort(met.begin(), met.end());
    entries += static_cast<std::size_t>(std::unique(met.begin(), met.end()) - met.begin());
  }
  return entries * seen.size() / samples;
}

DeviceRows::DeviceRows(Device& device, const SparseRows& rows, const char* what)
    : row_count_(static_cast<int>(rows.row_count())) {
  std::vector<std::uint32_t> begin = {0};
  std::vector<std::int32_t> columns;
  std::vector<float> weights;
  columns.reserve(rows.columns.size() + kEntriesOfBlock * rows.row_count());
  weights.reserve(rows.columns.size() + kEntriesOfBlock * rows.row_count());
  for (std::size_t r = 0; r < rows.row_count(); ++r) {
    for (std::uint32_t i = rows.begin[r]; i < rows.begin[r + 1]; ++i) {
      columns.push_back(static_cast<std::int32_t>(rows.columns[i]));
      weights.push_back(rows.weights[i]);
    }
    // Repeats the row's last column, because its texel is in the cache.
    while (columns.size() % kEntriesOfBlock != 0) {
      columns.push_back(columns.back());
      weights.push_back(0.0f);
    }
    begin.push_back(static_cast<std::uint32_t>(columns.size() / kEntriesOfBlock));
  }
  block_begin_ = uploaded(device, begin, what);
  columns_ = uploaded(device, columns, what);
  weights_ = uploaded(device, weights, what);
}

std::size_t DeviceRows::byte_count() const {
  return block_begin_.byte_count() + columns_.byte_count() + weights_.byte_count();
}

void DeviceRows::multiply(Kernel& kernel, const DeviceBuffer& x, DeviceBuffer& y) const {
  kernel.launch({static_cast<std::size_t>(row_count_), kRowsAnItem}, block_begin_, columns_, weights_, x, y,
                row_count_);
}

TextureSystem::TextureSystem(Device& the_device, const std::vector<InferenceView>& views,
                             const InferenceSettings& the_settings, int threads)
    : device(the_device), settings(the_settings) {
  add_views(views);
  const auto texel_count = static_cast<std::size_t>(layout.texel_count);
  const auto rows = static_cast<double>(rows_.row_count());
  pyramid_weight = settings.pyramid_weight * rows / static_cast<double>(texel_count);
  entry_count = rows_.columns.size();
  const SparseRows columns = transposed(rows_, texel_count);
  normal_entry_count = estimated_normal_entries(rows_, columns);
  uses_normal = settings.form == InferenceForm::kNormal ||
                (settings.form == InferenceForm::kAuto && normal_entry_count < kNormalEntriesMax * entry_count);
  if (uses_normal) {
    const SparseRows normal = normal_rows(rows_, columns, threads);
    normal_entry_count = normal.columns.size();
    normal_ = DeviceRows(device, normal, "A^T A");
  } else {
    matrix_ = DeviceRows(device, rows_, "the filter matrix");
    row_values_ = device.make_buffer(rows_.row_count() * sizeof(Colour4), "pixels");
  }
  transpose_ = DeviceRows(device, columns, "the filter matrix's transpose");
  const KernelVariant variant{1, 1, false};
  spmv_ = device.kernel("filter_matrix_spmv", "filter_matrix_spmv", variant);
  pyramid_residual_ = device.kernel("pyramidal_regularization", "pyramid_residual", variant);
  pyramid_gradient_ = device.kernel("pyramidal_regularization", "pyramid_gradient", variant);
  curvature_product = device.kernel("conjugate_gradient", "curvature_product", variant);
  advance_residual = device.kernel("conjugate_gradient", "advance_residual", variant);
  advance_direction = device.kernel("conjugate_gradient", "advance_direction", variant);
  std::vector<float> roots;
  for (const float root : root_weights_)
    if (root > 0.0f) roots.push_back(root);
  sums_.assign(texel_count, 0.0f);
  diagonal.assign(texel_count, 0.0f);
  for (std::size_t t = 0; t < texel_count; ++t)
    for (std::uint32_t i = columns.begin[t]; i < columns.begin[t + 1]; ++i) {
      sums_[t] += columns.weights[i] * roots[columns.columns[i]];
      diagonal[t] += columns.weights[i] * columns.weights[i];
    }
  if (has_pyramid()) make_pyramid();
}

void TextureSystem::add_views(const std::vector<InferenceView>& views) {
  MULTUM_CHECK(!views.empty());
  const FilterMatrix& first = *views.front().matrix;
  layout = first.layout();
  is_periodic_s = first.wrap_s == WrapMode::kPeriodic;
  is_periodic_t = first.wrap_t == WrapMode::kPeriodic;
  for (const InferenceView& view : views) {
    const FilterMatrix& m = *view.matrix;
    MULTUM_CHECK(view.row_weights.size() == m.row_count());
    if (m.texture_width != first.texture_width || m.texture_height != first.texture_height ||
        m.wrap_s != first.wrap_s || m.wrap_t != first.wrap_t || m.anisotropy != first.anisotropy ||
        m.has_mips != first.has_mips)
      throw Error(ErrorCode::kInput,
                  fmt::format("the filter matrices of '{}' in views '{}' and '{}' have different textures or samplers",
                              m.provenance.object, first.provenance.view, m.provenance.view));
    append_weighted_rows(view, rows_);
    for (const float weight : view.row_weights) root_weights_.push_back(weight > 0.0f ? std::sqrt(weight) : 0.0f);
  }
  if (rows_.row_count() == 0)
    throw Error(ErrorCode::kInput,
                fmt::format("object '{}' has no usable pixel in {} views, so its texture cannot be inferred",
                            first.provenance.object, views.size()));
}

void TextureSystem::make_pyramid() {
  const PyramidTables tables = make_pyramid_tables(layout, is_periodic_s, is_periodic_t, device.shape().strip_texels);
  levels_ = uploaded(device, tables.levels, "mip levels");
  taps_ = uploaded(device, tables.taps, "interpolation");
  gathers_ = uploaded(device, tables.gathers, "interpolation");
  gather_entries_ = uploaded(device, tables.entries, "interpolation");
  strips_ = uploaded(device, tables.strips, "strips of texels");
  strip_count_ = static_cast<int>(tables.strips.size());
  residual_ = make_texels("pyramid residuals");
  for (std::size_t t = 0; t < diagonal.size(); ++t)
    diagonal[t] += static_cast<float>(pyramid_weight) * tables.diagonal[t];
}

DeviceBuffer TextureSystem::make_texels(const char* what) {
  return device.make_buffer(static_cast<std::size_t>(layout.texel_count) * sizeof(Colour4), what);
}

void TextureSystem::apply(const DeviceBuffer& x, DeviceBuffer& sum) {
  if (uses_normal) {
    normal_.multiply(spmv_, x, sum);
  } else {
    matrix_.multiply(spmv_, x, row_values_);
    transpose_.multiply(spmv_, row_values_, sum);
  }
  if (!has_pyramid()) return;
  const Kernel::WorkSize size{static_cast<std::size_t>(strip_count_), device.shape().strip_local_size};
  pyramid_residual_.launch(size, levels_, taps_, strips_, x, residual_, strip_count_, layout.level_count());
  pyramid_gradient_.launch(size, levels_, gathers_, gather_entries_, strips_, residual_, sum, strip_count_,
                           static_cast<float>(pyramid_weight));
}

std::vector<Colour4> TextureSystem::projected(const std::vector<float>& colours, std::array<double, 3>* squares) {
  MULTUM_CHECK(colours.size() == 3 * root_weights_.size());
  std::vector<Colour4> b;
  *squares = {0.0, 0.0, 0.0};
  for (std::size_t r = 0; r < root_weights_.size(); ++r) {
    if (!(root_weights_[r] > 0.0f)) continue;
    Colour4 value{0.0f, 0.0f, 0.0f, 0.0f};
    for (std::size_t c = 0; c < 3; ++c) {
      value[c] = root_weights_[r] * colours[3 * r + c];
      (*squares)[c] += static_cast<double>(value[c]) * static_cast<double>(value[c]);
    }
    b.push_back(value);
  }
  DeviceBuffer pixels = device.make_buffer(b.size() * sizeof(Colour4), "pixels");
  device.write(pixels, b.data(), pixels.byte_count());
  DeviceBuffer sum = make_texels("projected pixels");
  transpose_.multiply(spmv_, pixels, sum);
  std::vector<Colour4> result(static_cast<std::size_t>(layout.texel_count));
  device.read(sum, result.data(), sum.byte_count());
  return result;
}

std::vector<float> TextureSystem::picture(const std::vector<float>& texels) const {
  std::vector<float> colours(3 * root_weights_.size(), 0.0f);
  for (std::size_t r = 0, row = 0; r < root_weights_.size(); ++r) {
    if (!(root_weights_[r] > 0.0f)) continue;
    for (std::uint32_t i = rows_.begin[row]; i < rows_.begin[row + 1]; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        colours[3 * r + c] += rows_.weights[i] / root_weights_[r] * texels[3 * rows_.columns[i] + c];
    ++row;
  }
  return colours;
}

}  // namespace multum
