// SPDX-License-Identifier: Apache-2.0
// Cuts the grid of parameters of a field into blocks, each coded as one texture chunk: for every layer of an object,
// boxes of samples that share a texture mapping, at most so many along each parameter that its textures vary with.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/asset/inferred/inferred_texture.h"

namespace multum {

struct FieldBlock {
  std::vector<int> begin, size;      // of a box, along each parameter
  std::vector<std::size_t> varying;  // parameters that its textures vary with, rising

  /// Sizes along `varying`; a single 1 when there is none.
  std::vector<std::size_t> chunk_sizes() const;
  /// The chunk's texture of a sample in the block.
  std::size_t chunk_sample(const std::vector<int>& at) const;
};

/// The samples of a field as a full grid.
struct SampleGrid {
  std::vector<std::size_t> sizes;      // along each parameter
  std::vector<std::size_t> sample_at;  // by position, the last parameter runs fastest: index into the samples

  std::size_t position_of(const std::vector<int>& at) const;
  /// Of a block that lies in the grid, by rising position.
  std::vector<std::size_t> samples_in(const FieldBlock& block) const;
};

/// Throws Error(kInput) unless every point of the grid has one sample; the caller's file is not named.
SampleGrid sample_grid(const std::vector<InferredSample>& samples);

/// Blocks that cover the grid, in a fixed order. `mapping_of_sample`, `textures`: of each sample; "" is no texture and
/// fits any. `side`, at least 1: samples along a varying parameter. `samples_max`, at least 1: textures of a block.
std::vector<FieldBlock> field_blocks(const InferredManifest& field, const SampleGrid& grid,
                                     const std::vector<int>& mapping_of_sample,
                                     const std::vector<std::string>& textures, int side, std::size_t samples_max);

}  // namespace multum
