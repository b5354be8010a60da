// SPDX-License-Identifier: Apache-2.0
// Cuts the parameter grid of a field into blocks. Each block of a layer is coded as one texture chunk. A block is a box
// of samples that share a texture mapping. A block has a limited number of samples along each parameter that changes
// its textures. Blocks of different objects may begin at different samples (Hakura et al. 2000, section 5), so that a
// path does not enter new blocks of all objects in one frame:
//
//      samples along a parameter   0 1 2 3 4 5 6 7 8 9        side 4
//      an object, first 0          |-------|-------|---
//      another, first 2            |---|-------|-------
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

struct FieldBlock {
  std::vector<int> begin, size;      // range of the box along each parameter
  std::vector<std::size_t> varying;  // parameters that change the textures, in ascending order

  /// Returns the sizes along `varying`, or a single 1 if nothing varies.
  std::vector<std::size_t> chunk_sizes() const;
  /// Returns the chunk's texture for a sample in the block.
  std::size_t chunk_sample(const std::vector<int>& at) const;
};

/// The samples of a field as a full grid.
struct SampleGrid {
  std::vector<std::size_t> sizes;      // along each parameter
  std::vector<std::size_t> sample_at;  // index into the samples by position; the last parameter changes fastest

  std::size_t position_of(const std::vector<int>& at) const;
  /// Returns the samples of a block in the grid, by ascending position.
  std::vector<std::size_t> samples_in(const FieldBlock& block) const;
};

/// Throws Error(kInput) unless every point of the grid has exactly one sample. The message does not name the file.
SampleGrid sample_grid(const std::vector<InferredSample>& samples);

struct BlockLimits {
  int side = 8;                 // samples along a varying parameter, at least 1
  int first = 0;                // length of the first block if a mapping has several, 0 to side; 0 means side
  std::size_t samples_max = 1;  // most textures of a block, at least 1
};

/// Returns blocks that cover the grid, in a fixed order. `mapping_of_sample` and `textures` have one entry per sample.
/// An empty texture name means that the sample has no texture, which fits every block.
std::vector<FieldBlock> field_blocks(const InferredManifest& field, const SampleGrid& grid,
                                     const std::vector<int>& mapping_of_sample,
                                     const std::vector<std::string>& textures, const BlockLimits& limits);

}  // namespace multum
