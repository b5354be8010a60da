// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_encoding.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <span>

#include "host/formats/asset/textures/scalar_block.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kLobeBlockSide = 4;
constexpr std::size_t kScalarBytes = 8;  // a block of BC4

// A channel of a level: what it should hold, and holds, 0 to 1.
using Channel = std::vector<float>;

// Stores a channel, and returns what is stored.
class ChannelStore {
 public:
  virtual ~ChannelStore() = default;
  virtual Channel store(int channel, const Channel& values) = 0;
};

// Four channels of a layer side by side.
class TexelStore : public ChannelStore {
 public:
  TexelStore(LobeTexels texels, std::size_t count)
      : is_half_(texels == LobeTexels::kRgba16f), bytes_(count * (is_half_ ? 8 : 4)) {}

  Channel store(int channel, const Channel& values) override {
    Channel stored(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t at = 4 * i + size_of(channel);
      if (is_half_) {
        const std::uint16_t half = clamped_to_half(values[i]);
        std::memcpy(&bytes_[2 * at], &half, 2);
        stored[i] = half_to_float(half);
      } else {
        bytes_[at] = static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(values[i], 0.0f, 1.0f)));
        stored[i] = static_cast<float>(bytes_[at]) / 255.0f;
      }
    }
    return stored;
  }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  const bool is_half_;
  std::vector<std::uint8_t> bytes_;
};

// Two channels a layer of BC5, a block of BC4 each.
class BlockStore : public ChannelStore {
 public:
  BlockStore(BlockEncoder& encoder, int width, int height)
      : encoder_(encoder),
        width_(width),
        height_(height),
        layer_bytes_(layer_bytes(LobeTexels::kBlocks, width, height)),
        bytes_(layer_bytes_ * size_of(layers_per_lobe(LobeTexels::kBlocks))) {}

  Channel store(int channel, const Channel& values) override {
    std::vector<glm::vec4> texels;
    texels.reserve(values.size());
    for (const float value : values) texels.emplace_back(value, 0.0f, 0.0f, 1.0f);
    const std::vector<std::uint8_t> blocks = encoder_.encode(TexelFormat::kBc4, width_, height_, texels);
    Channel stored(values.size());
    std::uint8_t* to = bytes_.data() + layer_bytes_ * size_of(channel / 2) + kScalarBytes * size_of(channel % 2);
    const std::uint8_t* from = blocks.data();
    for (int y = 0; y < height_; y += kLobeBlockSide)
      for (int x = 0; x < width_; x += kLobeBlockSide, from += kScalarBytes, to += 2 * kScalarBytes) {
        std::memcpy(to, from, kScalarBytes);
        const std::array<float, 16> decoded = decode_scalar_block(from);
        for (int j = 0; j < std::min(kLobeBlockSide, height_ - y); ++j)
          for (int i = 0; i < std::min(kLobeBlockSide, width_ - x); ++i)
            stored[size_of(y + j) * size_of(width_) + size_of(x + i)] = decoded[size_of(kLobeBlockSide * j + i)];
      }
    return stored;
  }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  BlockEncoder& encoder_;
  const int width_, height_;
  const std::size_t layer_bytes_;
  std::vector<std::uint8_t> bytes_;
};

// The moments as they are stored so far, next to those that are wanted.
struct StoredMoments {
  Channel x, y, s, a;
};

// The moment s that gives a lobe of amplitude `a` the wanted spread, with x and y as they are.
float s_of_spread(const glm::vec4& lobe, float x, float y, float a) {
  if (lobe.w <= 0.0f) return a;  // no lobe: what is stored of it by mistake has no direction
  const float scale = a / lobe.w;
  const float square = scale * scale * glm::dot(glm::vec3(lobe), glm::vec3(lobe)) - x * x - y * y;
  const float z = std::sqrt(std::max(square, 0.0f));
  return a - std::copysign(z, lobe.z);
}

}  // namespace

LobeUnpacking LobeEncoder::unpacking(const LobeBasis& basis) const {
  return texels_ == LobeTexels::kRgba16f ? plain_unpacking() : unpacking_of(basis);
}

std::vector<std::uint8_t> LobeEncoder::encode(const LobeBasis& basis, int width, int height,
                                              const std::vector<glm::vec4>& lobes) {
  const std::size_t count = lobes.size();
  MULTUM_CHECK(count == size_of(width) * size_of(height));
  const bool is_plain = texels_ == LobeTexels::kRgba16f;
  TexelStore in_texels(texels_, texels_ == LobeTexels::kBlocks ? 0 : count);
  BlockStore in_blocks(encoder_, width, height);
  ChannelStore& store = texels_ == LobeTexels::kBlocks ? static_cast<ChannelStore&>(in_blocks) : in_texels;

  // Stores values, and returns them as they are stored.
  const auto stored = [&](int channel, Channel values) {
    const float low = is_plain ? 0.0f : basis.low[channel];
    const float range = is_plain ? 1.0f : std::max(basis.high[channel] - low, 1e-30f);
    for (float& value : values) value = (value - low) / range;
    Channel kept = store.store(channel, values);
    for (float& value : kept) value = low + range * value;
    return kept;
  };
  const glm::vec2 mean = is_plain ? glm::vec2(0.0f) : basis.mean;
  const glm::vec3 predictor = is_plain ? glm::vec3(0.0f) : basis.predictor;

  StoredMoments moments;
  Channel wanted(count);
  for (std::size_t i = 0; i < count; ++i) wanted[i] = lobes[i].w;
  moments.a = stored(3, wanted);
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t i = 0; i < count; ++i)
      wanted[i] = (lobes[i].w > 0.0f ? lobes[i][axis] / lobes[i].w - mean[axis] : -mean[axis]) * moments.a[i];
    Channel& kept = axis == 0 ? moments.x : moments.y;
    kept = stored(axis, wanted);
    for (std::size_t i = 0; i < count; ++i) kept[i] += mean[axis] * moments.a[i];
  }
  for (std::size_t i = 0; i < count; ++i)
    wanted[i] = s_of_spread(lobes[i], moments.x[i], moments.y[i], moments.a[i]) -
                glm::dot(predictor, glm::vec3(moments.x[i], moments.y[i], moments.a[i]));
  stored(2, wanted);
  return texels_ == LobeTexels::kBlocks ? in_blocks.take() : in_texels.take();
}

}  // namespace multum
