// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/inference_rows.h"

#include <algorithm>

#include "host/formats/image/colour_map.h"

namespace multum {
namespace {

float row_coverage(const FilterMatrix& matrix, std::size_t row, const ObjectLayer& layer) {
  return std::min(matrix.coverage[row], layer.coverage[matrix.pixels[row]]);
}

}  // namespace

std::vector<float> row_weights(const FilterMatrix& matrix, const ObjectLayer& layer, double coverage_min) {
  std::vector<float> weights;
  for (std::size_t r = 0; r < matrix.row_count(); ++r) {
    const float weight = row_coverage(matrix, r, layer);
    weights.push_back(static_cast<double>(weight) >= coverage_min ? weight : 0.0f);
  }
  return weights;
}

bool is_whole_row(const FilterMatrix& matrix, std::size_t row, const ObjectLayer& layer) {
  return row_coverage(matrix, row, layer) >= kWholeCoverage;
}

void append_row_colours(const FilterMatrix& matrix, const ObjectLayer& layer, double radiance_max,
                        std::vector<float>& colours) {
  for (const std::uint32_t pixel : matrix.pixels)
    for (std::size_t c = 0; c < 3; ++c)
      colours.push_back(static_cast<float>(static_cast<double>(layer.rgb[3 * pixel + c]) / radiance_max));
}

std::array<float, 3> filtered(const FilterMatrix& matrix, std::size_t row, const std::vector<float>& texels) {
  std::array<float, 3> value{0.0f, 0.0f, 0.0f};
  for (std::uint32_t e = matrix.row_begin[row]; e < matrix.row_begin[row + 1]; ++e)
    for (std::size_t c = 0; c < 3; ++c) value[c] += matrix.weights[e] * texels[3 * matrix.columns[e] + c];
  return value;
}

void divide(std::vector<float>& values, double unit) {
  for (float& value : values) value = static_cast<float>(static_cast<double>(value) / unit);
}

double squared_error_8bit(const float* a, const float* b) {
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double va = srgb_from_linear(std::clamp(static_cast<double>(a[c]), 0.0, 1.0));
    const double vb = srgb_from_linear(std::clamp(static_cast<double>(b[c]), 0.0, 1.0));
    sum += 255.0 * 255.0 * (va - vb) * (va - vb) / 3.0;
  }
  return sum;
}

}  // namespace multum
