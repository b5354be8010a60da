// SPDX-License-Identifier: Apache-2.0
// Compares the sums of images that the GPU computes with the decoder's sums: gamma-coded sums, radiance, and every mip
// level.
#include "runtime_gl/animation/layer_sum.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/decoder/texture_chunk.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/split_mix.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

class LayerSumTest : public ::testing::TestWithParam<ContextBackend> {
 protected:
  const GlFunctions& gl() const { return context_->functions(); }
  std::unique_ptr<HeadlessContext> context_ = make_test_context(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Contexts, LayerSumTest, ::testing::ValuesIn(test_backends()),
                         [](const auto& test) { return context_backend_name(test.param); });

/// Returns a random multiple of 1/16, which is exact as a float and as a half float.
float image_value(SplitMix64& random, float size) {
  return std::round(size * static_cast<float>(random.uniform() - 0.5) * 16.0f) / 16.0f;
}

constexpr SamplerSettings kSampled = {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f};

TEST_P(LayerSumTest, EqualsTheDecoderAndItsMipLevels) {
  SplitMix64 random(3);
  LayerSum layer_sum(gl(), 67, 53);
  const struct {
    int width, height, images;
  } cases[] = {{67, 53, 3}, {64, 32, 8}, {33, 1, 9}, {1, 53, 25}, {6, 10, 1}, {5, 7, 0}, {1, 1, 2}};
  for (const auto& [width, height, count] : cases) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height) + " of " + std::to_string(count));
    const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::array<float, 3> offset = {90.0f, 12.5f, 200.0f};
    std::vector<float> sum(3 * texels);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = offset[i % 3];
    std::vector<Texture> textures;
    std::vector<float> weights;
    textures.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) {
      weights.push_back(k == 0 ? 1.0f : static_cast<float>(random.uniform() - 0.5));
      std::vector<std::uint16_t> halves(4 * texels);
      for (std::size_t i = 0; i < sum.size(); ++i) {
        const float value = image_value(random, k == 0 ? 120.0f : 40.0f);
        halves[i / 3 * 4 + i % 3] = float_to_half(value);
        sum[i] += weights.back() * value;
      }
      textures.emplace_back(gl(), "image", TextureShape{width, height, 1, TexelFormat::kRgba16f},
                            SamplerSettings{WrapMode::kClamp, WrapMode::kClamp, false, 1.0f});
      textures.back().upload_rows(0, 0, height / 2, halves.data());  // in two parts
      textures.back().upload_rows(0, height / 2, height - height / 2,
                                  halves.data() + 4 * static_cast<std::size_t>(width * (height / 2)));
    }
    std::vector<WeighedTexture> weighed;
    for (std::size_t k = 0; k < textures.size(); ++k) weighed.push_back({&textures[k], weights[k]});
    std::vector<float> finest = sum;
    for (float& value : finest) value = radiance_of(value);
    const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
    const std::vector<float> expected = mip_levels(w, h, finest);
    int levels = 1;
    while (width >> levels > 0 || height >> levels > 0) ++levels;
    const Texture target(gl(), "target", {width, height, levels, TexelFormat::kRgba16f}, kSampled);
    for (int round = 0; round < 2; ++round) layer_sum.add_up(weighed, offset, target);  // overwrites the first sum
    std::size_t at = 0;
    double bias = 0.0;
    for (int l = 0; l < levels; ++l) {
      const std::vector<float> found = target.read_level(l);
      for (std::size_t i = 0; i < found.size() / 4; ++i, ++at)
        for (std::size_t c = 0; c < 3; ++c) {
          const float value = expected[3 * at + c];
          // Rounding to a 16-bit float changes a value by at most 2^-12 of the value. Each further level rounds once
          // more. llvmpipe's pow has an error of up to 2e-4.
          ASSERT_NEAR(found[4 * i + c], value, 1e-3f * value + 1e-6f) << "level " << l << " texel " << i;
          bias += static_cast<double>(found[4 * i + c] - value) / static_cast<double>(value + 1e-3f);
        }
    }
    if (at > 1000) {
      EXPECT_LT(std::abs(bias) / static_cast<double>(3 * at), 1e-4)
          << "values must be rounded to nearest, not truncated";
    }
  }
}

}  // namespace
}  // namespace multum::gl
