// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/field_blocks.h"

#include <algorithm>
#include <map>
#include <optional>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

class BlockCutter {
 public:
  BlockCutter(const InferredManifest& field, const SampleGrid& grid, const std::vector<int>& mapping_of_sample,
              const std::vector<std::string>& textures, const BlockLimits& limits)
      : field_(field), grid_(grid), mappings_(mapping_of_sample), textures_(textures), limits_(limits) {}

  /// Cuts a box into smaller boxes that each have a single mapping, and cuts these boxes into blocks.
  void cut(const FieldBlock& box) {
    const auto place = mapping_change(box);
    if (!place) return cut_mapped(box, box);
    const auto [first, second] = parted(box, place->first, place->second);
    cut(first);
    cut(second);
  }

  std::vector<FieldBlock> blocks() && { return std::move(blocks_); }

 private:
  template <typename Visit>
  void over_samples(const FieldBlock& block, const Visit& visit) const {
    for (const std::size_t sample : grid_.samples_in(block)) visit(sample, field_.samples[sample].at);
  }

  static std::pair<FieldBlock, FieldBlock> parted(const FieldBlock& block, std::size_t dimension, int length) {
    FieldBlock first = block, second = block;
    first.size[dimension] = length;
    second.begin[dimension] += length;
    second.size[dimension] -= length;
    return {first, second};
  }

  /// Cuts `block`. All of its samples have the same mapping.
  void cut_mapped(FieldBlock block, const FieldBlock& box) {
    find_varying(block);
    const auto place = cut_of(block, box);
    if (!place) return blocks_.push_back(std::move(block));
    const auto [first, second] = parted(block, place->first, place->second);
    cut_mapped(first, box);
    cut_mapped(second, box);
  }

  /// Returns the dimension to cut and the length of the first part, or nullopt if the block is small enough.
  std::optional<std::pair<std::size_t, int>> cut_of(const FieldBlock& block, const FieldBlock& box) const {
    std::size_t samples = 1;
    for (const std::size_t d : block.varying) {
      const bool is_first = limits_.first > 0 && box.size[d] > limits_.side && block.begin[d] == box.begin[d];
      const int length = is_first ? limits_.first : limits_.side;
      if (block.size[d] > length) return std::pair(d, length);
      samples *= static_cast<std::size_t>(block.size[d]);
    }
    if (samples <= limits_.samples_max) return {};
    const std::size_t longest = *std::max_element(block.varying.begin(), block.varying.end(),
                                                  [&](auto a, auto b) { return block.size[a] < block.size[b]; });
    return std::pair(longest, block.size[longest] / 2);
  }

  /// Returns the dimension along which the mapping changes first, and the distance of this change from the block's
  /// beginning.
  std::optional<std::pair<std::size_t, int>> mapping_change(const FieldBlock& block) const {
    std::optional<std::pair<std::size_t, int>> found;
    for (std::size_t d = 0; d < block.size.size(); ++d) {
      over_samples(block, [&](std::size_t sample, std::vector<int> at) {
        const int distance = at[d] - block.begin[d];
        if (distance == 0) return;
        --at[d];
        const bool changes = mappings_[sample] != mappings_[grid_.sample_at[grid_.position_of(at)]];
        if (changes && (!found || distance < found->second)) found = std::pair(d, distance);
      });
      if (found) return found;
    }
    return found;
  }

  /// Returns whether all samples that share a texture of the chunk really have the same texture.
  bool fits(const FieldBlock& block) const {
    std::map<std::size_t, std::string> names;
    bool all = true;
    over_samples(block, [&](std::size_t sample, const std::vector<int>& at) {
      if (textures_[sample].empty()) return;
      all = names.emplace(block.chunk_sample(at), textures_[sample]).first->second == textures_[sample] && all;
    });
    return all;
  }

  void find_varying(FieldBlock& block) const {
    block.varying.clear();
    for (std::size_t d = 0; d < block.size.size(); ++d)
      if (block.size[d] > 1) block.varying.push_back(d);
    for (std::size_t d = 0; d < block.size.size(); ++d) {
      FieldBlock without = block;
      std::erase(without.varying, d);
      if (without.varying.size() < block.varying.size() && fits(without)) block = without;
    }
  }

  const InferredManifest& field_;
  const SampleGrid& grid_;
  const std::vector<int>& mappings_;
  const std::vector<std::string>& textures_;
  BlockLimits limits_;
  std::vector<FieldBlock> blocks_;
};

}  // namespace

std::size_t SampleGrid::position_of(const std::vector<int>& at) const {
  std::size_t position = 0;
  for (std::size_t d = 0; d < sizes.size(); ++d) position = position * sizes[d] + static_cast<std::size_t>(at[d]);
  return position;
}

std::vector<std::size_t> SampleGrid::samples_in(const FieldBlock& block) const {
  std::vector<std::size_t> samples;
  std::vector<int> at = block.begin;
  while (true) {
    samples.push_back(sample_at[position_of(at)]);
    std::size_t d = at.size();
    while (d > 0 && ++at[d - 1] == block.begin[d - 1] + block.size[d - 1]) {
      at[d - 1] = block.begin[d - 1];
      --d;
    }
    if (d == 0) return samples;
  }
}

SampleGrid sample_grid(const std::vector<InferredSample>& samples) {
  SampleGrid grid;
  grid.sizes.resize(samples.front().at.size(), 1);
  const auto refuse = [] { throw Error(ErrorCode::kInput, "its samples do not form a full grid of the parameters"); };
  std::size_t count = 1;
  for (std::size_t d = 0; d < grid.sizes.size(); ++d) {
    for (const InferredSample& sample : samples) {
      if (sample.at[d] < 0 || sample.at[d] >= std::ssize(samples)) refuse();
      grid.sizes[d] = std::max(grid.sizes[d], static_cast<std::size_t>(sample.at[d]) + 1);
    }
    count *= grid.sizes[d];
    if (count > samples.size()) refuse();
  }
  if (count != samples.size()) refuse();
  grid.sample_at.resize(count, count);
  for (std::size_t s = 0; s < samples.size(); ++s) {
    std::size_t& place = grid.sample_at[grid.position_of(samples[s].at)];
    if (place != count) refuse();
    place = s;
  }
  return grid;
}

std::vector<std::size_t> FieldBlock::chunk_sizes() const {
  std::vector<std::size_t> sizes;
  for (const std::size_t d : varying) sizes.push_back(static_cast<std::size_t>(size[d]));
  if (sizes.empty()) sizes.push_back(1);
  return sizes;
}

std::size_t FieldBlock::chunk_sample(const std::vector<int>& at) const {
  std::size_t number = 0;
  for (const std::size_t d : varying)
    number = number * static_cast<std::size_t>(size[d]) + static_cast<std::size_t>(at[d] - begin[d]);
  return number;
}

std::vector<FieldBlock> field_blocks(const InferredManifest& field, const SampleGrid& grid,
                                     const std::vector<int>& mapping_of_sample,
                                     const std::vector<std::string>& textures, const BlockLimits& limits) {
  BlockCutter cutter(field, grid, mapping_of_sample, textures, limits);
  FieldBlock whole;
  for (const std::size_t size : grid.sizes) {
    whole.begin.push_back(0);
    whole.size.push_back(static_cast<int>(size));
  }
  cutter.cut(whole);
  return std::move(cutter).blocks();
}

}  // namespace multum
