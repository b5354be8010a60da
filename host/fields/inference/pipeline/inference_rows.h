// SPDX-License-Identifier: Apache-2.0
// Presents an object's layer as the rows of its filter matrix see it: how much each pixel counts, what it shows, and
// what a texture makes of it.
#pragma once

#include <array>
#include <vector>

#include "host/fields/inference/mapping/layer_segmentation.h"
#include "host/fields/inferred/filter_matrix.h"

namespace multum {

/// Coverage of each row: of the ray-traced picture and of the GL's, the less; 0 where that is below `coverage_min`.
std::vector<float> row_weights(const FilterMatrix& matrix, const ObjectLayer& layer, double coverage_min);

/// Whether both the ray-traced picture and the GL cover the row's pixel wholly. What a mixed pixel shows of an object
/// is a guess of the segmentation.
bool is_whole_row(const FilterMatrix& matrix, std::size_t row, const ObjectLayer& layer);

/// Appends the row's pixels, three values each, in units of `radiance_max`.
void append_row_colours(const FilterMatrix& matrix, const ObjectLayer& layer, double radiance_max,
                        std::vector<float>& colours);

/// One row of A x.
std::array<float, 3> filtered(const FilterMatrix& matrix, std::size_t row, const std::vector<float>& texels);

/// Each value over `unit`.
void divide(std::vector<float>& values, double unit);

/// Mean squared difference of two colours in 8-bit sRGB units, clipped to what such a picture holds.
double squared_error_8bit(const float* a, const float* b);

}  // namespace multum
