// SPDX-License-Identifier: Apache-2.0
#include "host/codec/chunk_choice.h"

#include <algorithm>
#include <bit>
#include <optional>

namespace multum {

std::vector<ParameterPyramid::Halvings> plain_levels(const std::vector<std::size_t>& sizes) {
  ParameterPyramid::Halvings top;
  for (const std::size_t size : sizes) top.push_back(static_cast<std::uint8_t>(std::bit_width(size - 1)));
  std::vector<ParameterPyramid::Halvings> levels = {top};
  while (std::any_of(levels.back().begin(), levels.back().end(), [](auto times) { return times > 0; })) {
    auto next = levels.back();
    const auto most = *std::max_element(next.begin(), next.end());
    for (auto& times : next)
      if (times == most) --times;
    levels.push_back(next);
  }
  return levels;
}

std::vector<ParameterPyramid::Halvings> chosen_levels(
    const std::vector<std::size_t>& sizes,
    const std::function<double(const std::vector<ParameterPyramid::Halvings>&)>& cost) {
  const auto plain = plain_levels(sizes);
  std::vector<ParameterPyramid::Halvings> levels = {plain.front()};
  if (plain.size() > 1) levels.push_back(plain.back());
  double least = cost(levels);
  for (std::size_t below = 1; below < levels.size();) {
    std::optional<ParameterPyramid::Halvings> best;
    // Every level between the last one chosen and the finest: each dimension anywhere between both.
    ParameterPyramid::Halvings candidate(sizes.size(), 0);
    for (bool more = true; more;) {
      if (candidate != levels[below - 1] && candidate != levels[below]) {
        auto tried = levels;
        tried.insert(tried.begin() + static_cast<std::ptrdiff_t>(below), candidate);
        if (const double value = cost(tried); value < least) {
          least = value;
          best = candidate;
        }
      }
      more = false;
      for (std::size_t d = 0; d < candidate.size() && !more; ++d) {
        if (candidate[d] < levels[below - 1][d]) {
          ++candidate[d];
          more = true;
        } else {
          candidate[d] = 0;
        }
      }
    }
    if (!best) break;
    levels.insert(levels.begin() + static_cast<std::ptrdiff_t>(below), *best);
    ++below;
  }
  return levels;
}

EncodedChunk best_chunk(const SourceOfLayout& source_of, const ChunkCandidates& candidates, double lambda) {
  std::optional<EncodedChunk> best;
  ChunkSettings kept;
  kept.lambda = lambda;
  const auto try_settings = [&](const ChunkSettings& settings, const ChunkSource& source) {
    EncodedChunk chunk = encode_chunk(source, settings);
    if (best && chunk.cost(lambda) >= best->cost(lambda)) return false;
    best = std::move(chunk);
    kept = settings;
    return true;
  };
  const auto layout_of = [](const ChunkSettings& settings) { return std::pair(settings.coder, settings.side); };
  for (const auto& [coder, side] : candidates.coders) {
    const ChunkSource source = source_of(coder, side);
    ChunkSettings settings = kept;  // of the coders before, the best pyramid or basis
    settings.coder = coder;
    settings.side = side;
    if (best) {
      try_settings(settings, source);
      if (layout_of(kept) != layout_of(settings)) continue;
    }
    for (const auto& levels : candidates.pyramids) {
      settings.levels = levels;
      try_settings(settings, source);
    }
    settings.levels.clear();
    for (const std::size_t images :
         candidates.basis_images) {  // rising: more images stop paying once they have stopped
      settings.basis_images = images;
      const bool is_first = images == candidates.basis_images.front();
      if (!try_settings(settings, source) && !is_first) break;
    }
  }
  return std::move(*best);
}

}  // namespace multum
