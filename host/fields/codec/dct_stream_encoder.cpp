// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/dct_stream_encoder.h"

#include <cmath>

#include "host/fields/codec/decoder/block_dct.h"

namespace multum {
namespace {

/// An isolated coefficient needs about this many bits. Coefficients that save less are not tried.
constexpr float kBitsLeast = 3.0f;
/// The most bits that can be saved by dropping a coefficient, or by lowering it by one step. A change is not tried if
/// it adds more error than these bits are worth. This shortcut changed files of field_demo1 by less than 0.1 %.
constexpr float kBitsOfOneMost = 14.0f, kBitsOfStepMost = 4.0f;

bool all_zero(std::span<const std::int16_t> values) {
  return std::all_of(values.begin(), values.end(), [](auto value) { return value == 0; });
}

}  // namespace

float DctStreamEncoder::bits_of(Values& values, const BlockSurroundings& around) {
  CountingPort port;
  SymbolCoder<CountingPort> counter(port);
  syntax_.block(counter, values, around);
  return port.bits();
}

/// Returns the extra bits that mark a group as not empty instead of empty.
float DctStreamEncoder::opening_bits(const GroupSurroundings& around) {
  CountingPort some, none;
  SymbolCoder<CountingPort> of_some(some), of_none(none);
  syntax_.group(of_some, true, around);
  syntax_.group(of_none, false, around);
  return some.bits() - none.bits();
}

/// Returns the values to write for a block. The decoder adds `constant` to the first value. If any value is not zero,
/// `bits_if_any` is added to the cost of the block.
DctStreamEncoder::Values DctStreamEncoder::chosen_values(const DctTarget& target, std::size_t plane, std::size_t number,
                                                         int constant, const BlockSurroundings& around,
                                                         float bits_if_any) {
  const std::size_t size = grid_.side * grid_.side;
  const float* wanted = target.coefficients[plane].data() + number * size;
  const float* weights = target.weights.data() + number * size;
  const auto step = [&](std::size_t at) { return target.scale * target.steps[at]; };
  const auto offset = [&](std::size_t at) { return at == 0 ? constant : 0; };
  const auto error = [&](std::size_t at, int value) {
    const float difference = wanted[at] - step(at) * static_cast<float>(value + offset(at));
    return weights[at] * difference * difference;
  };

  Values values(size);
  for (std::size_t at = 0; at < size; ++at) {
    const float exact = wanted[at] / step(at) - static_cast<float>(offset(at));
    const auto value = static_cast<std::int16_t>(
        std::lround(std::clamp(exact, -static_cast<float>(CoefficientBlocks::kMagnitudeMax / 2),
                               static_cast<float>(CoefficientBlocks::kMagnitudeMax / 2))));
    if (value != 0 && error(at, 0) - error(at, value) > kBitsLeast * target.lambda) values[at] = value;
  }
  if (all_zero(values)) return values;

  const auto cost = [&](Values& candidate) {
    float sum = target.lambda * bits_of(candidate, around);
    for (std::size_t at = 0; at < size; ++at)
      if (values[at] != candidate[at] || candidate[at] != 0) sum += error(at, candidate[at]) - error(at, 0);
    return sum;
  };
  float least = cost(values);
  const auto keep_if_better = [&](Values& candidate) {
    float sum = target.lambda * bits_of(candidate, around);
    for (std::size_t at = 0; at < size; ++at)
      if (candidate[at] != 0) sum += error(at, candidate[at]) - error(at, 0);
    if (sum >= least) return;
    least = sum;
    values = candidate;
  };
  for (std::size_t k = syntax_.band_count(); k-- > 0;)
    for (std::size_t i = syntax_.band(k).size(); i-- > 0;) {
      const std::size_t at = syntax_.band(k)[i];
      if (values[at] == 0) continue;
      const auto nearer = static_cast<std::int16_t>(values[at] - (values[at] > 0 ? 1 : -1));
      const float bits = nearer == 0 ? kBitsOfOneMost : kBitsOfStepMost;
      if (error(at, nearer) - error(at, values[at]) > bits * target.lambda) continue;
      Values candidate = values;
      candidate[at] = nearer;
      keep_if_better(candidate);
    }
  for (std::size_t k = syntax_.band_count(); k-- > 0;) {
    Values candidate = values;
    for (const std::uint16_t at : syntax_.band(k)) candidate[at] = 0;
    if (candidate != values) keep_if_better(candidate);
  }
  least += target.lambda * bits_if_any;
  Values none(size);
  keep_if_better(none);
  return values;
}

/// Delays writing the first groups of the plane, and the first blocks of a group, until one of them is not empty.
void DctStreamEncoder::add_plane(CoefficientBlocks& image, const DctTarget& target, const ImagePlace& place,
                                 std::size_t plane) {
  const auto around_group = [&](std::size_t group) {
    return groups_.surroundings(image, place.parent, place.before, plane, group, place.level);
  };
  const auto around_block = [&](std::size_t number) {
    return surroundings(image, place.parent, grid_, plane, number, place.level);
  };
  Values none(grid_.side * grid_.side);
  bool is_plane_open = false;
  const auto open_group = [&](std::size_t group, std::size_t first_coded) {
    if (!is_plane_open) {
      coder_.bit(false, empty_plane_);
      for (std::size_t before = 0; before < group; ++before) syntax_.group(coder_, false, around_group(before));
    }
    is_plane_open = true;
    syntax_.group(coder_, true, around_group(group));
    for (const std::size_t before : groups_.blocks(group))
      if (before < first_coded) syntax_.block(coder_, none, around_block(before));
  };
  for (std::size_t group = 0; group < groups_.count(); ++group) {
    const auto numbers = groups_.blocks(group);
    const float opening = opening_bits(around_group(group));
    bool is_open = false;
    for (const std::size_t number : numbers) {
      const int constant = place.parent == nullptr ? predicted_constant(image, grid_, plane, number) : 0;
      Values values = chosen_values(target, plane, number, constant, around_block(number), is_open ? 0.0f : opening);
      const bool is_first = !is_open && !all_zero(values);
      if (is_first) open_group(group, number);
      is_open = is_open || is_first;
      if (is_open) syntax_.block(coder_, values, around_block(number), is_first && number == numbers.back());
      values[0] = static_cast<std::int16_t>(values[0] + constant);
      if (!all_zero(values)) std::copy(values.begin(), values.end(), image.make(plane, number).begin());
    }
    if (!is_open && is_plane_open) syntax_.group(coder_, false, around_group(group));
  }
  if (!is_plane_open) coder_.bit(true, empty_plane_);
}

CoefficientBlocks DctStreamEncoder::add_image(const DctTarget& target, const CoefficientBlocks* parent,
                                              const CoefficientBlocks* before, std::size_t level) {
  CoefficientBlocks image(grid_.count(), grid_.side * grid_.side);
  for (std::size_t plane = 0; plane < CoefficientBlocks::kPlanes; ++plane)
    add_plane(image, target, {parent, before, level}, plane);
  return image;
}

std::vector<float> block_coefficients(const BlockGrid& grid, std::span<const float> samples) {
  const std::size_t side = grid.side;
  std::vector<float> coefficients(grid.count() * side * side);
  for (std::size_t number = 0; number < grid.count(); ++number) {
    const std::span<float> block(coefficients.data() + number * side * side, side * side);
    const std::size_t left = number % grid.columns() * side, top = number / grid.columns() * side;
    for (std::size_t y = 0; y < side; ++y)
      for (std::size_t x = 0; x < side; ++x)
        block[y * side + x] =
            samples[std::min(top + y, grid.height - 1) * grid.width + std::min(left + x, grid.width - 1)];
    forward_dct(static_cast<int>(side), block, block);
  }
  return coefficients;
}

}  // namespace multum
