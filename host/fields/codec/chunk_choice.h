// SPDX-License-Identifier: Apache-2.0
// Chooses how a chunk is coded: its pyramid over parameters, or a basis learnt from the block, and its image coder, by
// what error + lambda bits come out.
#pragma once

#include <utility>

#include "host/fields/codec/texture_chunk_encoder.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// 1, 2, 4 ... samples along every dimension together: the plain pyramid.
std::vector<ParameterPyramid::Halvings> plain_levels(const std::vector<std::size_t>& sizes);

/// Chooses the order of dimensions and the levels (Hakura et al. 2000, section 4, "Adaptive Laplacian Pyramid"): a
/// greedy search from the single image at the top. Each step tries to insert every level that fits below the last one
/// chosen, and keeps what makes `cost`, of whole lists of levels, least; ends where none does.
std::vector<ParameterPyramid::Halvings> chosen_levels(
    const std::vector<std::size_t>& sizes,
    const std::function<double(const std::vector<ParameterPyramid::Halvings>&)>& cost);

/// An image coder and the side of cosine blocks.
using CoderAndSide = std::pair<ImageCoder, std::size_t>;

/// What is tried, in this order. `coder`: of all when not given.
std::vector<CoderAndSide> image_coders(std::optional<ImageCoder> coder);

struct ChunkCandidates {
  std::vector<CoderAndSide> coders;  // at least one
  std::vector<std::vector<ParameterPyramid::Halvings>> pyramids;
  bool has_greedy = false;
  std::vector<std::size_t> basis_images;  // rising; at least one pyramid, has_greedy, or one of these
  bool open_loop = false;
};

/// `coder`: of all when not given.
ChunkCandidates chunk_candidates(const std::vector<std::size_t>& sizes, PyramidChoice pyramid,
                                 std::optional<ImageCoder> coder, bool open_loop);

/// Textures do not depend on the coder, weights of coefficients do.
using WeightsOfLayout = std::function<CoefficientWeights(ImageCoder coder, std::size_t side)>;

struct ChosenChunk {
  EncodedChunk chunk;
  ChunkSettings settings;  // that it was coded with
};

/// The chunk of least error + lambda bits. The first coder tries every pyramid and, while more images pay, every basis;
/// a later one what was best so far, and the others only where it is better at that. `step`: as ChunkEncoder has it.
ChosenChunk best_chunk(const ChunkSource& source, const WeightsOfLayout& weights_of, const ChunkCandidates& candidates,
                       double lambda, const std::function<void()>& step);

}  // namespace multum
