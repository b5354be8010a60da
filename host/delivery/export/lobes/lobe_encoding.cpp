// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/lobes/lobe_encoding.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "host/delivery/export/lobes/lobe_rounding.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kBandRows = 64;  // rows of a level per band: a multiple of a block's side

// Weights of errors. A lobe's error is weighted by its amplitude, so that small lobes keep their direction and spread,
// and large lobes compensate errors of the sums. Broader lobes have less weight, because errors of their moments are
// less visible. At level 3 of a real map (a barrel, 2048 x 2048 texels, BC5), these weights of the sums reduce the rms
// error of the sum of amplitudes from 2.9 % to 1.5 %, and the error of the mean normal from 1.6 to 1.4 degrees. The
// table lists the percentage points that storage adds to the error of a picture of metal with roughness 0.4
// (accuracy/storage_error.h). In the first column, lobes are rounded one by one. In the second column, they are rounded
// together with weights of 1 / amplitude. In the third column, they are rounded together with the weights below.
//
//     barrel, 2048 x 2048                          1.47   1.49   1.37
//     Corset, 256 x 256                            0.50   0.74   0.46
//     re_pipes01 of the shared data, 512 x 512     1.77   2.19   1.81
constexpr float kAmplitudeSumWeight = 12.0f, kAxisSumWeight = 50.0f, kSpreadSumWeight = 3.0f;
constexpr float kLeastAmplitude = 0.1f, kLeastSpread = 0.02f;

// The moments of a band's texels that have been stored so far, lobe by lobe.
struct StoredMoments {
  std::vector<std::vector<float>> x, y, a;
};

// Returns the moment s that gives a lobe of amplitude `a` the wanted spread, for the given x and y.
float s_of_spread(const glm::vec4& lobe, float x, float y, float a) {
  if (lobe.w <= 0.0f)
    return a;  // there is no lobe, only an amplitude that consists of rounding errors and has no
               // direction
  const float scale = a / lobe.w;
  const float square = scale * scale * glm::dot(glm::vec3(lobe), glm::vec3(lobe)) - x * x - y * y;
  const float z = std::sqrt(std::max(square, 0.0f));
  return a - std::copysign(z, lobe.z);
}

float weight_of_lobe(const glm::vec4& lobe, int channel) {
  const float spread = lobe.w > 0.0f ? std::max(1.0f - glm::length(glm::vec3(lobe)) / lobe.w, 0.0f) : 1.0f;
  const float width = spread + kLeastSpread, amplitude = lobe.w + kLeastAmplitude;
  return 1.0f / (amplitude * amplitude * (channel == 3 ? 1.0f : channel == 2 ? width * width : width));
}

// The rows of all lobes of a level.
class LobeBand {
 public:
  LobeBand(const std::vector<LobeBasis>& bases, const std::vector<std::vector<glm::vec4>>& lobes, std::size_t first,
           std::size_t count, LobeRounding& rounding)
      : bases_(bases), lobes_(lobes), first_(first), count_(count), rounding_(rounding) {}

  void round() {
    round_amplitudes();
    for (int axis = 0; axis < 2; ++axis) round_axis(axis);
    round_spreads();
  }

 private:
  const glm::vec4& lobe(std::size_t j, std::size_t i) const { return lobes_[j][first_ + i]; }

  // Rounds a channel and returns the stored values. `wanted(j, i)` and `offset(j, i)` are for lobe j and texel i.
  template <typename Wanted, typename Offset>
  std::vector<std::vector<float>> rounded(int channel, const Wanted& wanted, const Offset& offset,
                                          const std::vector<float>& sums, float sum_weight) {
    std::vector<RoundedChannel> channels;
    for (std::size_t j = 0; j < bases_.size(); ++j) {
      const float low = bases_[j].low[channel];
      RoundedChannel one{low, bases_[j].high[channel] - low, {}, {}, {}};
      for (std::size_t i = 0; i < count_; ++i) {
        one.wanted.push_back(wanted(j, i));
        one.offset.push_back(offset(j, i));
        one.weight.push_back(weight_of_lobe(lobe(j, i), channel));
      }
      channels.push_back(std::move(one));
    }
    rounding_.round(channel, channels, sums, sum_weight);
    std::vector<std::vector<float>> stored;
    for (RoundedChannel& one : channels) stored.push_back(std::move(one.wanted));
    return stored;
  }

  template <typename Value>
  std::vector<float> sums(const Value& value) const {
    std::vector<float> made(count_, 0.0f);
    for (std::size_t j = 0; j < bases_.size(); ++j)
      for (std::size_t i = 0; i < count_; ++i) made[i] += value(j, i);
    return made;
  }

  void round_amplitudes() {
    const auto amplitude = [&](std::size_t j, std::size_t i) { return lobe(j, i).w; };
    stored_.a = rounded(
        3, amplitude, [](std::size_t, std::size_t) { return 0.0f; }, sums(amplitude), kAmplitudeSumWeight);
  }

  // Keeps the direction of each lobe for its stored amplitude.
  void round_axis(int axis) {
    const auto wanted = [&](std::size_t j, std::size_t i) {
      const glm::vec4& one = lobe(j, i);
      return one.w > 0.0f ? one[axis] / one.w * stored_.a[j][i] : 0.0f;
    };
    const auto offset = [&](std::size_t j, std::size_t i) { return bases_[j].mean[axis] * stored_.a[j][i]; };
    const auto sum = sums([&](std::size_t j, std::size_t i) { return lobe(j, i)[axis]; });
    (axis == 0 ? stored_.x : stored_.y) = rounded(axis, wanted, offset, sum, kAxisSumWeight);
  }

  void round_spreads() {
    const auto wanted = [&](std::size_t j, std::size_t i) {
      return s_of_spread(lobe(j, i), stored_.x[j][i], stored_.y[j][i], stored_.a[j][i]);
    };
    const auto offset = [&](std::size_t j, std::size_t i) {
      return glm::dot(bases_[j].predictor, glm::vec3(stored_.x[j][i], stored_.y[j][i], stored_.a[j][i]));
    };
    const auto sum = sums([&](std::size_t j, std::size_t i) { return stored_.a[j][i] - lobe(j, i).z; });
    rounded(2, wanted, offset, sum, kSpreadSumWeight);
  }

  const std::vector<LobeBasis>& bases_;
  const std::vector<std::vector<glm::vec4>>& lobes_;
  const std::size_t first_, count_;
  LobeRounding& rounding_;
  StoredMoments stored_;
};

// Half floats store the moments themselves.
LobeBasis plain_basis() { return {}; }

}  // namespace

LobeUnpacking LobeEncoder::unpacking(const LobeBasis& basis) const {
  return texels_ == LobeTexels::kRgba16f ? plain_unpacking() : unpacking_of(basis);
}

std::vector<std::uint8_t> LobeEncoder::encode(const std::vector<LobeBasis>& bases, int width, int height,
                                              const std::vector<std::vector<glm::vec4>>& lobes, Progress* progress) {
  MULTUM_CHECK(lobes.size() == bases.size());
  for (const auto& one : lobes) MULTUM_CHECK(one.size() == size_of(width) * size_of(height));
  const bool is_plain = texels_ == LobeTexels::kRgba16f;
  const std::vector<LobeBasis> used = is_plain ? std::vector<LobeBasis>(bases.size(), plain_basis()) : bases;
  const int lobe_count = static_cast<int>(bases.size()), layer_count = layers_per_lobe(texels_);
  const std::size_t of_layer = layer_bytes(texels_, width, height);
  std::vector<std::uint8_t> layers(of_layer * size_of(lobe_count * layer_count));
  for (int row = 0; row < height; row += kBandRows) {
    const int rows = std::min(kBandRows, height - row);
    const std::unique_ptr<LobeRounding> rounding = make_lobe_rounding(texels_, encoder_, lobe_count, width, rows);
    LobeBand(used, lobes, size_of(row) * size_of(width), size_of(rows) * size_of(width), *rounding).round();
    const std::size_t before = row > 0 ? layer_bytes(texels_, width, row) : 0;
    for (int j = 0; j < lobe_count; ++j)
      for (int k = 0; k < layer_count; ++k) {
        const std::vector<std::uint8_t>& from = rounding->layer(j, k);
        std::copy(from.begin(), from.end(), layers.data() + of_layer * size_of(j * layer_count + k) + before);
      }
    progress_advance(progress, size_of(lobe_count) * size_of(rows) * size_of(width));
  }
  return layers;
}

}  // namespace multum
