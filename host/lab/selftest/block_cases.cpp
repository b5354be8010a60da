// SPDX-License-Identifier: Apache-2.0
// Tests BC4 and BC7 blocks (kernels/block_encoding.cl). Some blocks have values at the limits or the same value in all
// texels, and some have indices whose highest bit is not stored.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/delivery/export/block_decoding.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/block_encoding.h"
#include "host/lab/selftest/buffers.h"
#include "host/lab/selftest/case_lists.h"

namespace multum {
namespace {

// Contains the values of one block, from 0 to 255, channel by channel. Decoded texels have the same range.
using BlockInput = std::vector<float>;

std::vector<BlockTexels> decoded_blocks(Device& device, TexelFormat format, const std::vector<BlockInput>& blocks) {
  std::vector<float> values;
  for (const BlockInput& block : blocks) values.insert(values.end(), block.begin(), block.end());
  const auto block_bytes = static_cast<std::size_t>(info_of(format).block_bytes);
  const DeviceBuffer out =
      uploaded(device, std::vector<std::uint8_t>(block_bytes * blocks.size(), 0xa5), "encoded blocks");
  const DeviceBuffer in = uploaded(device, values, "values of blocks");
  const int count = static_cast<int>(blocks.size());
  constexpr int kThirdIsBlue = 0;
  if (format == TexelFormat::kBc7)
    device.kernel("block_encoding", "encode_colour_blocks", {1, 1, false})
        .launch({blocks.size()}, in, out, count, kThirdIsBlue);
  else device.kernel("block_encoding", "encode_scalar_blocks", {1, 1, false}).launch({blocks.size()}, in, out, count);
  const std::vector<std::uint8_t> bytes = downloaded<std::uint8_t>(device, out);
  std::vector<BlockTexels> decoded;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    decoded.push_back(decode_block(format, bytes.data() + b * block_bytes));
    for (glm::vec4& texel : decoded.back()) texel *= 255.0f;
  }
  return decoded;
}

// Returns the root mean square difference of one channel.
double rms_of(const BlockTexels& decoded, const BlockInput& block, int channel) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 16; ++i) {
    const double d = static_cast<double>(decoded[i][channel]) -
                     static_cast<double>(block[16 * static_cast<std::size_t>(channel) + i]);
    sum += d * d;
  }
  return std::sqrt(sum / 16.0);
}

// Tests blocks in which half of the values are 0 or 255, as in occlusion and clamped roughness.
void values_at_the_limits(Device& device, WorstError& worst) {
  SplitMix64 random(71);
  std::vector<BlockInput> blocks;
  for (int b = 0; b < 8; ++b) {
    BlockInput block;
    const double middle = 60.0 + 130.0 * random.uniform();
    for (int i = 0; i < 16; ++i)
      block.push_back(i % 4 == 0 ? 0.0f : i % 4 == 1 ? 255.0f : static_cast<float>(middle + 30.0 * random.uniform()));
    blocks.push_back(block);
  }
  const std::vector<BlockTexels> decoded = decoded_blocks(device, TexelFormat::kBc4, blocks);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    reference::BlockValues values{};
    for (std::size_t i = 0; i < 16; ++i) values[i] = static_cast<double>(blocks[b][i]);
    const double least = std::sqrt(reference::least_scalar_error(values) / 16.0);
    worst.add(std::max(0.0, rms_of(decoded[b], blocks[b], 0) - least), fmt::format("block {}", b));
  }
}

// Tests blocks with equal texels, which have no value range and no principal axis.
void one_value_in_all_texels(Device& device, TexelFormat format, WorstError& worst) {
  std::vector<BlockInput> blocks;
  const std::size_t channels = format == TexelFormat::kBc7 ? 3 : 1;
  for (const float value : {0.0f, 1.0f, 77.0f, 128.0f, 254.0f, 255.0f}) {
    BlockInput block;
    for (std::size_t c = 0; c < channels; ++c) block.insert(block.end(), 16, c == 1 ? 255.0f - value : value);
    blocks.push_back(block);
  }
  const std::vector<BlockTexels> decoded = decoded_blocks(device, format, blocks);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (std::size_t c = 0; c < channels; ++c)
      worst.add(rms_of(decoded[b], blocks[b], static_cast<int>(c)), fmt::format("block {}, channel {}", b, c));
}

// Tests colour ramps that rise or fall from the first texel, with and without a second part.
void indices_without_their_highest_bit(Device& device, WorstError& worst) {
  std::vector<BlockInput> blocks;
  for (const bool falls : {false, true})
    for (const bool has_parts : {false, true}) {
      BlockInput block;
      for (const float share : {1.0f, 0.5f, has_parts ? -1.0f : 0.25f})
        for (int i = 0; i < 16; ++i) {
          const bool is_first = has_parts && i % 4 < 2;
          const float along = static_cast<float>(falls ? 15 - i : i) / 15.0f;
          block.push_back(128.0f + share * (is_first ? 40.0f : -40.0f) + (is_first ? 30.0f : 60.0f) * (along - 0.5f));
        }
      blocks.push_back(block);
    }
  const std::vector<BlockTexels> decoded = decoded_blocks(device, TexelFormat::kBc7, blocks);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    for (int c = 0; c < 3; ++c) worst.add(rms_of(decoded[b], blocks[b], c), fmt::format("block {}, channel {}", b, c));
}

}  // namespace

std::vector<NumericalCase> block_cases() {
  const std::string unit = "root mean square error on a scale of 255";
  const auto scalar = [](Device& device, WorstError& worst) {
    one_value_in_all_texels(device, TexelFormat::kBc4, worst);
  };
  const auto colour = [](Device& device, WorstError& worst) {
    one_value_in_all_texels(device, TexelFormat::kBc7, worst);
  };
  return {
      {{"values-at-the-limits", "encode_scalar_blocks",
        "if the endpoints of a block are 0 and 255, the values between them are far apart",
        "the encoder also tries the six-value mode, in which blocks contain 0 and 255 in addition to the endpoints",
        0.3, unit + " in excess of the lowest possible error",
        "the steps of the encoder's search are smaller than the rounding error of the values"},
       values_at_the_limits,
       {{"block_encoding", "has_limits = other.error < ends.error;", ""}}},
      {{"one-value-in-all-texels", "encode_scalar_blocks",
        "a block with equal or swapped endpoints is decoded in the six-value mode",
        "the encoder gives eight-value blocks different endpoints, and stores the larger endpoint first", 1e-3, unit,
        "the encoder uses the value of the texels as an endpoint"},
       scalar,
       {},
       {},
       {{"block_encoding", "put_bits(&bits, (uint)(has_limits ? ends.low : ends.high), 8);",
         "put_bits(&bits, (uint)ends.low, 8);"},
        {"block_encoding", "put_bits(&bits, (uint)(has_limits ? ends.high : ends.low), 8);",
         "put_bits(&bits, (uint)ends.high, 8);"}}},
      {{"one-colour-in-all-texels", "encode_colour_blocks", "a block of equal texels has no principal axis",
        "the encoder uses an arbitrary direction", 1.0, unit,
        "an alpha of 255 forces all endpoints of mode 6 to be odd numbers"},
       colour,
       {},
       {},
       {{"block_encoding", "if (length < 1e-6f) return (float4)", "if (length < -1.0f) return (float4)"},
        {"block_encoding", "return length < 1e-6f ? (float4)", "return length < -1.0f ? (float4)"}}},
      {{"indices-without-their-highest-bit", "encode_colour_blocks",
        "the highest index bit of each subset's anchor texel is not stored",
        "if the highest index bit is set, the endpoints of the subset are swapped", 2.0, unit,
        "the eight indices of the mode must cover a range of 60, so each value is rounded to one of eight levels"},
       indices_without_their_highest_bit,
       {{"block_encoding", "if (indices[anchor] <= last / 2) return 0;", "return 0;"}}},
  };
}

}  // namespace multum
