// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/parameter_pyramid.h"

#include <algorithm>

namespace multum {
namespace {

constexpr std::uint8_t kHalvingsMax = 16;  // no grid has more than 2^16 samples

std::size_t halved(std::size_t size, std::size_t times) { return ((size - 1) >> times) + 1; }

}  // namespace

std::optional<ParameterPyramid> ParameterPyramid::of(std::vector<std::size_t> sizes, std::vector<Halvings> levels) {
  if (sizes.empty() || sizes.size() > kDimensionsMax || levels.empty() || levels.size() > kLevelsMax) return {};
  ParameterPyramid pyramid;
  for (const std::size_t size : sizes) {
    if (size < 1 || size > kSamplesMax || (pyramid.sample_count_ *= size) > kSamplesMax) return {};
  }
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (levels[l].size() != sizes.size()) return {};
    bool halves_less = l == 0;
    for (std::size_t d = 0; d < sizes.size(); ++d) {
      if (levels[l][d] > kHalvingsMax || (l > 0 && levels[l][d] > levels[l - 1][d])) return {};
      halves_less |= l > 0 && levels[l][d] < levels[l - 1][d];
    }
    if (!halves_less) return {};
  }
  if (std::any_of(levels.back().begin(), levels.back().end(), [](auto times) { return times != 0; })) return {};
  pyramid.sizes_ = std::move(sizes);
  pyramid.levels_ = std::move(levels);
  pyramid.first_image_.push_back(0);
  for (std::size_t l = 0; l < pyramid.levels_.size(); ++l) {
    std::size_t count = 1;
    for (std::size_t d = 0; d < pyramid.sizes_.size(); ++d) count *= pyramid.cells(l, d);
    pyramid.first_image_.push_back(pyramid.first_image_.back() + count);
  }
  return pyramid;
}

std::size_t ParameterPyramid::cells(std::size_t level, std::size_t dimension) const {
  return halved(sizes_[dimension], levels_[level][dimension]);
}

std::vector<std::size_t> ParameterPyramid::indices_of(std::size_t sample) const {
  std::vector<std::size_t> at(sizes_.size());
  for (std::size_t d = sizes_.size(); d-- > 0; sample /= sizes_[d]) at[d] = sample % sizes_[d];
  return at;
}

std::size_t ParameterPyramid::level_of(std::size_t image) const {
  const auto above = std::upper_bound(first_image_.begin(), first_image_.end(), image);
  return static_cast<std::size_t>(above - first_image_.begin()) - 1;
}

std::size_t ParameterPyramid::image_of(std::size_t level, std::size_t sample) const {
  const auto at = indices_of(sample);
  std::size_t number = 0;
  for (std::size_t d = 0; d < sizes_.size(); ++d) number = number * cells(level, d) + (at[d] >> levels_[level][d]);
  return first_image_[level] + number;
}

std::vector<std::size_t> ParameterPyramid::samples_of(std::size_t image) const {
  const std::size_t level = level_of(image);
  std::vector<std::size_t> samples;
  for (std::size_t s = 0; s < sample_count_; ++s)
    if (image_of(level, s) == image) samples.push_back(s);
  return samples;
}

std::optional<std::size_t> ParameterPyramid::parent_of(std::size_t image) const {
  const std::size_t level = level_of(image);
  if (level == 0) return {};
  std::size_t number = image - first_image_[level], sample = 0, stride = 1;
  for (std::size_t d = sizes_.size(); d-- > 0;) {  // the first sample of the image's cell
    sample += stride * (number % cells(level, d) << levels_[level][d]);
    number /= cells(level, d);
    stride *= sizes_[d];
  }
  return image_of(level - 1, sample);
}

std::vector<ParameterPyramid::Term> ParameterPyramid::terms(std::size_t level, std::size_t sample, bool linear) const {
  if (!linear) return {{image_of(level, sample), 1.0f}};
  const auto at = indices_of(sample);
  std::vector<Term> terms = {{0, 1.0f}};
  for (std::size_t d = 0; d < sizes_.size(); ++d) {
    const std::size_t count = cells(level, d), times = levels_[level][d];
    // Computes the middle of the samples in the cell. The last cell may have fewer samples.
    const auto middle = [&](std::size_t cell) {
      const std::size_t first = cell << times, end = std::min(sizes_[d], (cell + 1) << times);
      return (static_cast<float>(first) + static_cast<float>(end - 1)) / 2.0f;
    };
    std::size_t low = at[d] >> times;
    const auto position = static_cast<float>(at[d]);
    if (low > 0 && position < middle(low)) --low;
    const std::size_t high = std::min(low + 1, count - 1);
    const float share =
        high == low ? 0.0f : std::clamp((position - middle(low)) / (middle(high) - middle(low)), 0.0f, 1.0f);
    std::vector<Term> next;
    for (const Term& term : terms) {
      if (share < 1.0f) next.push_back({term.image * count + low, term.weight * (1.0f - share)});
      if (share > 0.0f) next.push_back({term.image * count + high, term.weight * share});
    }
    terms = std::move(next);
  }
  for (Term& term : terms) term.image += first_image_[level];
  return terms;
}

}  // namespace multum
