// SPDX-License-Identifier: Apache-2.0
// Chooses how to code a chunk: the image coder, and either a pyramid over the parameters or a basis learnt from the
// block. The chosen settings minimise error + lambda bits.
#pragma once

#include <utility>

#include "host/fields/codec/texture_chunk_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// Returns the plain pyramid: 1, 2, 4 ... samples along every dimension.
std::vector<ParameterPyramid::Halvings> plain_levels(const std::vector<std::size_t>& sizes);

/// Chooses the order of dimensions and the levels (Hakura et al. 2000, section 4, "Adaptive Laplacian Pyramid"). The
/// greedy search starts with the single image at the top. Each step tries every level that fits below the last chosen
/// one, and adds the level that gives the least `cost`. The search ends when no further level lowers the cost.
std::vector<ParameterPyramid::Halvings> chosen_levels(
    const std::vector<std::size_t>& sizes,
    const std::function<double(const std::vector<ParameterPyramid::Halvings>&)>& cost);

/// An image coder and the side of cosine blocks.
using CoderAndSide = std::pair<ImageCoder, std::size_t>;

/// Returns the coders to try, in order. These are only `coder` if it is set, and otherwise all coders.
std::vector<CoderAndSide> image_coders(std::optional<ImageCoder> coder);

struct ChunkCandidates {
  std::vector<CoderAndSide> coders;  // at least one
  std::vector<std::vector<ParameterPyramid::Halvings>> pyramids;
  bool has_greedy = false;
  std::vector<std::size_t> basis_images;  // image counts in ascending order; may be empty only if `pyramids` is not
                                          // empty or has_greedy is set
  bool open_loop = false;
};

/// If `coder` is set, only this coder is tried.
ChunkCandidates chunk_candidates(const std::vector<std::size_t>& sizes, PyramidChoice pyramid,
                                 std::optional<ImageCoder> coder, bool open_loop);

/// Returns the weights of the coefficients for a coder. The textures are the same for all coders.
using WeightsOfLayout = std::function<CoefficientWeights(ImageCoder coder, std::size_t side)>;

struct ChosenChunk {
  EncodedChunk chunk;
  ChunkSettings settings;  // the settings that coded the chunk
};

/// Returns the chunk with the least error + lambda bits. First tries every pyramid with the first coder, and then
/// larger bases as long as more images lower the cost. Each later coder is first tried with the best settings so far.
/// Its other settings are tried only if it then has the lowest cost. `step` is as in ChunkEncoder.
ChosenChunk best_chunk(const ChunkSource& source, const WeightsOfLayout& weights_of, const ChunkCandidates& candidates,
                       double lambda, const std::function<void()>& step);

}  // namespace multum
