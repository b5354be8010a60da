// SPDX-License-Identifier: Apache-2.0
// Weighs errors of textures by what the runtime draws of them: the filter matrix A of each pose says what each texel is
// in each pixel, so an error e of a texture is |A e|^2 in the picture. Coded coefficients have errors that are nearly
// independent, so it is summed by coefficient: |A b|^2 of each basis image b, its weight. Weights are measured, not
// computed one by one: basis images of one frequency at all places at once, with random signs, are drawn, and the
// squares of the pixels are handed back to the texels that they came from.
#pragma once

#include <cstdint>
#include <vector>

#include "host/fields/codec/image_transforms.h"
#include "host/fields/inferred/filter_matrix.h"

namespace multum {

/// Side of the squares of texels over which shares of layers are averaged.
constexpr std::size_t kShareCell = 16;

/// What the square of an error of each coefficient weighs in the picture of each pose: cosines [pose][block][v][u],
/// wavelets [pose][height][width]. All matrices are of textures of the layout's size. Coefficients whose place is seen
/// in part, or has a neighbour that is seen, weigh more than that: their errors are not independent where little of
/// them is seen.
std::vector<std::vector<float>> coefficient_energies(const std::vector<FilterMatrix>& matrices,
                                                     const CoefficientLayout& layout);

/// By how much energies of cosines grow in each block of which only a part is seen: errors of coefficients add up
/// there. `masses`: texel_masses. Energies of coefficient_energies have grown by it.
std::vector<float> partly_seen_factors(const CoefficientLayout& layout, const std::vector<float>& masses);

/// What the finest texels, with what the coarser ones hand down to them, weigh in the picture: A^T 1.
std::vector<float> texel_masses(const FilterMatrix& matrix);

/// By how much errors of each layer's gamma-coded texture show in the gamma-coded sum of the layers, squared, for each
/// cell of kShareCell texels a side, row by row: (L_i / L)^(2 - 2 / 2.2), the mean over the pixels in which the cell is
/// seen, times their coverage squared; cells that nothing sees have the mean of the others. `layers`: radiance of all
/// levels, [texel][3].
std::vector<std::vector<float>> layer_shares(const FilterMatrix& matrix,
                                             const std::vector<const std::vector<float>*>& layers);

/// The cell of each coefficient.
std::vector<std::uint32_t> cells_of_coefficients(const CoefficientLayout& layout);

/// Sums of a value of each texel over each cell, row by row; `texels`: [height][width].
std::vector<float> cell_sums(std::size_t width, const std::vector<float>& texels);

}  // namespace multum
