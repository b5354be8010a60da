// SPDX-License-Identifier: Apache-2.0
// Converts an object's layer to the rows of its filter matrix. A row has the weight of each pixel, its colour, and the
// colour that a texture gives.
#pragma once

#include <array>
#include <vector>

#include "host/fields/inference/mapping/layer_segmentation.h"
#include "host/fields/inferred/filter_matrix.h"

namespace multum {

/// Returns the coverage of each row, which is the lower of its coverages in the ray-traced picture and in OpenGL. The
/// coverage is 0 if this is below `coverage_min`.
std::vector<float> row_weights(const FilterMatrix& matrix, const ObjectLayer& layer, double coverage_min);

/// Returns whether the object covers the row's pixel wholly both in the ray-traced picture and in OpenGL. In a mixed
/// pixel, the object's colour is only an estimate from the segmentation.
bool is_whole_row(const FilterMatrix& matrix, std::size_t row, const ObjectLayer& layer);

/// Appends the row's pixels, with three values per pixel, in units of `radiance_max`.
void append_row_colours(const FilterMatrix& matrix, const ObjectLayer& layer, double radiance_max,
                        std::vector<float>& colours);

/// Returns one row of A x.
std::array<float, 3> filtered(const FilterMatrix& matrix, std::size_t row, const std::vector<float>& texels);

/// Divides each value by `unit`.
void divide(std::vector<float>& values, double unit);

/// Returns the mean squared difference of two colours in 8-bit sRGB units, clipped to the range of 8-bit pictures.
double squared_error_8bit(const float* a, const float* b);

}  // namespace multum
