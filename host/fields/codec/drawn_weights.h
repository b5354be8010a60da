// SPDX-License-Identifier: Apache-2.0
// Computes weights for the errors of textures from the visibility of these errors in the drawn picture. The filter
// matrix A of a pose contains the share of each texel in each pixel, so a texture error e causes a squared error of |A
// e|^2 in the picture. The errors of coded coefficients are nearly independent, so the squared error in the picture is
// a weighted sum over coefficients. The weight of a coefficient with basis image b is |A b|^2. All weights of one
// frequency are measured together. The basis images of this frequency are drawn at once with random signs, and the
// squares of the pixels are distributed to the texels that they show.
#pragma once

#include <cstdint>
#include <vector>

#include "host/fields/codec/image_transforms.h"
#include "host/fields/inferred/filter_matrix.h"

namespace multum {

/// The side, in texels, of the squares over which layer_shares() averages.
constexpr std::size_t kShareCell = 16;

/// Returns the weight of each coefficient's squared error in the picture of each pose. Cosines are [pose][block][v][u],
/// and wavelets are [pose][height][width]. All matrices are for textures of the layout's size. Partly visible
/// coefficients, and wavelets next to visible ones, get higher weights, because the errors of such coefficients are not
/// independent.
std::vector<std::vector<float>> coefficient_energies(const std::vector<FilterMatrix>& matrices,
                                                     const CoefficientLayout& layout);

/// Returns one factor per block for the energies of the block's cosines. The factor exceeds 1 in partly visible blocks,
/// because the errors of their coefficients add up. `masses` comes from texel_masses(). The result of
/// coefficient_energies() already includes this factor.
std::vector<float> partly_seen_factors(const CoefficientLayout& layout, const std::vector<float>& masses);

/// Returns the weights of the finest texels in the picture, including the coarser levels. This is A^T 1.
std::vector<float> texel_masses(const FilterMatrix& matrix);

/// Returns how much an error of each layer's gamma-coded texture changes the gamma-coded sum of the layers. The result
/// has one squared visibility per layer and cell of kShareCell x kShareCell texels, row by row. The value is (L_i /
/// L)^(2 - 2 / 2.2) times the squared coverage, averaged over the pixels that show the cell. Invisible cells get the
/// mean of the visible cells. Each of the `layers` has the radiance of all mip levels, [texel][3].
std::vector<std::vector<float>> layer_shares(const FilterMatrix& matrix,
                                             const std::vector<const std::vector<float>*>& layers);

/// Returns the cell of each coefficient.
std::vector<std::uint32_t> cells_of_coefficients(const CoefficientLayout& layout);

/// Returns the sum of the texels' values in each cell, row by row. `texels` is [height][width].
std::vector<float> cell_sums(std::size_t width, const std::vector<float>& texels);

}  // namespace multum
