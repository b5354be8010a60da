// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/chunk_choice.h"

#include <algorithm>
#include <bit>
#include <limits>
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
    // Tries every level between the last chosen level and the finest one. Tries every possible number of halvings along
    // each dimension.
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

std::vector<CoderAndSide> image_coders(std::optional<ImageCoder> coder) {
  std::vector<CoderAndSide> coders;
  for (const CoderAndSide& one :
       {CoderAndSide(ImageCoder::kDct, 16), CoderAndSide(ImageCoder::kDct, 8), CoderAndSide(ImageCoder::kWavelet, 16)})
    if (!coder || one.first == *coder) coders.push_back(one);
  return coders;
}

ChunkCandidates chunk_candidates(const std::vector<std::size_t>& sizes, PyramidChoice pyramid,
                                 std::optional<ImageCoder> coder, bool open_loop) {
  ChunkCandidates candidates;
  candidates.open_loop = open_loop;
  candidates.coders = image_coders(coder);
  const auto plain = plain_levels(sizes);
  const auto& top = plain.front();
  const auto& finest = plain.back();
  if (pyramid == PyramidChoice::kNone || plain.size() == 1) {
    candidates.pyramids = {{finest}};
    return candidates;
  }
  if (pyramid == PyramidChoice::kGreedy) {
    candidates.has_greedy = true;
    return candidates;
  }
  candidates.pyramids.push_back(plain);
  if (pyramid == PyramidChoice::kPlain) return candidates;
  if (sizes.size() == 1) {
    if (plain.size() > 2) candidates.pyramids.push_back({top, finest});
  } else {
    auto first_along_one = top;
    first_along_one.front() = 0;
    if (first_along_one != top && first_along_one != finest)
      candidates.pyramids.push_back({top, first_along_one, finest});
    // Refines one dimension at a time, starting with the last dimension.
    std::vector<ParameterPyramid::Halvings> taking_turns = {top};
    for (auto next = top; next != finest; taking_turns.push_back(next)) {
      const auto most = std::max_element(next.rbegin(), next.rend());
      --*most;
    }
    candidates.pyramids.push_back(taking_turns);
  }
  candidates.basis_images = sizes.size() == 1 ? std::vector<std::size_t>{4, 8} : std::vector<std::size_t>{8, 12};
  return candidates;
}

namespace {

/// Wavelets take several times as long to decode as cosines, so they are chosen only if they lower the cost by at least
/// 5 %.
constexpr double kWaveletFactor = 1.05;

double comparable_cost(const EncodedChunk& chunk, ImageCoder coder, double lambda) {
  return (coder == ImageCoder::kWavelet ? kWaveletFactor : 1.0) * chunk.cost(lambda);
}

}  // namespace

ChosenChunk best_chunk(const ChunkSource& source, const WeightsOfLayout& weights_of, const ChunkCandidates& candidates,
                       double lambda, const std::function<void()>& step) {
  std::optional<ChosenChunk> best;
  for (const auto& [coder, side] : candidates.coders) {
    ChunkEncoder encoder(source, weights_of(coder, side), coder, side);
    ChunkSettings settings;
    if (best) settings = best->settings;  // the best pyramid or basis of the previous coders
    settings.lambda = lambda;
    settings.open_loop = candidates.open_loop;
    settings.coder = coder;
    settings.side = side;
    const auto try_settings = [&] {
      EncodedChunk chunk = encoder.encode(settings, step);
      const double cost = comparable_cost(chunk, settings.coder, lambda);
      if (!best || cost < comparable_cost(best->chunk, best->settings.coder, lambda))
        best = {std::move(chunk), settings};
      return cost;
    };
    const auto is_best = [&] { return best->settings.coder == settings.coder && best->settings.side == settings.side; };
    if (best) {
      try_settings();
      if (!is_best()) continue;
    }
    if (candidates.has_greedy && candidates.coders.front() == std::pair(coder, side))
      chosen_levels(source.sizes, [&](const auto& levels) {
        settings.levels = levels;
        return try_settings();
      });
    for (const auto& levels : candidates.pyramids) {
      settings.levels = levels;
      try_settings();
    }
    settings.levels.clear();
    double least = std::numeric_limits<double>::max();
    for (const std::size_t images : candidates.basis_images) {  // stops when more images do not lower the cost
      settings.basis_images = images;
      const double cost = try_settings();
      if (cost >= least) break;
      least = cost;
    }
  }
  return std::move(*best);
}

}  // namespace multum
