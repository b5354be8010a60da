// SPDX-License-Identifier: Apache-2.0
// Tests that uploads keep the precision of the encoding, and that the hardware filters like a filter in double
// precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"
#include "runtime_gl/gl/texture.h"
#include "tests/gl/shader_harness.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

using Levels = std::vector<std::vector<float>>;

struct Pyramid {
  TextureShape shape;
  Levels levels;  // values that the format holds exactly
};

int level_size(int size, int level) { return std::max(1, size >> level); }

double half_to_double(std::uint16_t half) {
  const int exponent = (half >> 10) & 31;
  const int mantissa = half & 1023;
  const double sign = (half & 0x8000) != 0 ? -1.0 : 1.0;
  return sign * (exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25));
}

float representable(TexelFormat format, float value) {
  if (format == TexelFormat::kRgba16Snorm) return static_cast<float>(std::lround(value * 32767.0f)) / 32767.0f;
  return format == TexelFormat::kRgba16f ? static_cast<float>(half_to_double(float_to_half(value))) : value;
}

Pyramid random_pyramid(const TextureShape& shape, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f);
  Pyramid pyramid{shape, {}};
  for (int l = 0; l < shape.level_count; ++l) {
    std::vector<float> level(4u * static_cast<unsigned>(level_size(shape.width, l) * level_size(shape.height, l)));
    for (float& value : level) value = representable(shape.format, uniform(generator));
    pyramid.levels.push_back(std::move(level));
  }
  return pyramid;
}

Texture upload(const GlFunctions& gl, const Pyramid& pyramid, const SamplerSettings& sampler) {
  Texture texture(gl, "test", pyramid.shape, sampler);
  for (int l = 0; l < pyramid.shape.level_count; ++l)
    texture.upload_level(l, pyramid.levels[static_cast<std::size_t>(l)].data());
  return texture;
}

/// Returns the wrapped index, or -1 for the border.
int wrap_index(WrapMode mode, int i, int size) {
  const int period = mode == WrapMode::kMirror ? 2 * size : size;
  const int m = ((i % period) + period) % period;
  switch (mode) {
    case WrapMode::kBlack: return i >= 0 && i < size ? i : -1;
    case WrapMode::kClamp: return std::clamp(i, 0, size - 1);
    case WrapMode::kPeriodic: return m;
    case WrapMode::kMirror: return m < size ? m : period - 1 - m;
  }
  return 0;
}

double bilinear(const Pyramid& pyramid, WrapMode wrap, int level, double s, double t, int channel) {
  const int width = level_size(pyramid.shape.width, level);
  const int height = level_size(pyramid.shape.height, level);
  const double x = s * width - 0.5;
  const double y = t * height - 0.5;
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int i = static_cast<int>(std::floor(x)) + (k & 1);
    const int j = static_cast<int>(std::floor(y)) + (k >> 1);
    const int u = wrap_index(wrap, i, width);
    const int v = wrap_index(wrap, j, height);
    if (u < 0 || v < 0) continue;
    const double weight = (1.0 - std::abs(x - i)) * (1.0 - std::abs(y - j));
    const float texel =
        pyramid.levels[static_cast<std::size_t>(level)][static_cast<std::size_t>(4 * (v * width + u) + channel)];
    sum += weight * static_cast<double>(texel);
  }
  return sum;
}

double trilinear(const Pyramid& pyramid, WrapMode wrap, const glm::vec4& at, int channel) {
  const int level_max = pyramid.shape.level_count - 1;
  const double lod = std::clamp<double>(static_cast<double>(at.z), 0.0, level_max);
  const int fine = static_cast<int>(lod);
  const int coarse = std::min(fine + 1, level_max);
  const double s = static_cast<double>(at.x);
  const double t = static_cast<double>(at.y);
  return (1.0 - (lod - fine)) * bilinear(pyramid, wrap, fine, s, t, channel) +
         (lod - fine) * bilinear(pyramid, wrap, coarse, s, t, channel);
}

class TextureTest : public testing::TestWithParam<TexelFormat> {
 protected:
  void SetUp() override { context_ = make_test_context(test_backend()); }
  const GlFunctions& gl() const { return context_->functions(); }
  std::unique_ptr<HeadlessContext> context_;
};

TEST_P(TextureTest, RoundTripKeepsEveryValue) {
  const Pyramid pyramid = random_pyramid({21, 10, 5, GetParam()}, 1);
  const Texture texture = upload(gl(), pyramid, {});
  for (int l = 0; l < 5; ++l) {
    const std::vector<float> read = texture.read_level(l);
    const std::vector<float>& written = pyramid.levels[static_cast<std::size_t>(l)];
    ASSERT_EQ(read.size(), written.size());
    // Allows one float step for the driver's own division by 32767.
    for (std::size_t i = 0; i < read.size(); ++i)
      ASSERT_NEAR(read[i], written[i], GetParam() == TexelFormat::kRgba16Snorm ? 6e-8f : 0.0f) << l << " " << i;
  }
}

TEST_P(TextureTest, RoundsToNearest) {
  Texture texture(gl(), "test", {1, 1, 1, GetParam()}, {});
  const float value = 0.3333333f;
  const float rgba[4] = {value, -value, 1.0f, -1.0f};
  texture.upload_level(0, rgba);
  const std::vector<float> read = texture.read_level(0);
  const float step = GetParam() == TexelFormat::kRgba16Snorm ? 1.0f / 32767.0f
                     : GetParam() == TexelFormat::kRgba16f   ? 1.0f / 4096.0f
                                                             : 0.0f;
  EXPECT_NEAR(read[0], value, 0.501f * step);
  EXPECT_EQ(read[1], -read[0]);
  EXPECT_EQ(read[2], 1.0f);
  EXPECT_EQ(read[3], -1.0f);
}

TEST_P(TextureTest, FiltersLikeDoublePrecision) {
  const Pyramid pyramid = random_pyramid({37, 20, 6, GetParam()}, 2);
  std::mt19937 generator(3);
  std::uniform_real_distribution<float> place(-1.5f, 2.5f);
  std::uniform_real_distribution<float> lod(-0.5f, 5.5f);
  std::vector<glm::vec4> at;
  for (int i = 0; i < 4000; ++i) at.emplace_back(place(generator), place(generator), lod(generator), 0.0f);
  for (const WrapMode wrap : {WrapMode::kBlack, WrapMode::kClamp, WrapMode::kPeriodic, WrapMode::kMirror}) {
    const Texture texture = upload(gl(), pyramid, {wrap, wrap, true, 1.0f});
    const auto values = evaluate_shader(gl(), {"textureLod(map, a.xy, a.z)", at, at, &texture});
    double error_max = 0.0;
    for (std::size_t i = 0; i < at.size(); ++i)
      for (int c = 0; c < 4; ++c) {
        const double off = static_cast<double>(values[i][c]) - trilinear(pyramid, wrap, at[i], c);
        error_max = std::max(error_max, std::abs(off));
        ASSERT_FALSE(std::isnan(off));
      }
    // s * width is at most 2.5 * 37 texels, and its rounding error is 8e-6 texels. This error is multiplied by
    // differences of up to 2 and occurs a few times.
    EXPECT_LT(error_max, filter_tolerance(*context_, 3e-5, 2e-2)) << wrap_mode_name(wrap);
  }
}

TEST_P(TextureTest, RefusesSizesBeyondTheDevice) {
  try {
    Texture texture(gl(), "lobe 0", {1 << 20, 1, 1, GetParam()}, {});
    FAIL() << "a texture of 2^20 texels was allocated";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
    EXPECT_NE(std::string(error.what()).find("lobe 0 is 1048576 x 1"), std::string::npos) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, TextureTest,
                         testing::Values(TexelFormat::kRgba16Snorm, TexelFormat::kRgba16f, TexelFormat::kRgba32f),
                         [](const auto& test) { return std::string(texel_format_name(test.param)); });

TEST(Half, ClampedOnesAreTheSameUpToTheLargest) {
  std::mt19937 random(6);
  for (int i = 0; i < 2000000; ++i) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isnan(value)) continue;
    ASSERT_EQ(clamped_to_half(value), float_to_half(std::clamp(value, -65504.0f, 65504.0f))) << value;
  }
}

TEST(Half, RoundsToNearestEvenOverAllExponents) {
  // Tests every 16-bit float. Also tests the 32-bit floats just below, at and just above the midpoint between each pair
  // of neighbouring 16-bit floats.
  for (std::uint32_t h = 0; h < 0x7bff; ++h) {
    const auto low = static_cast<std::uint16_t>(h);
    const auto high = static_cast<std::uint16_t>(h + 1);
    const float middle = static_cast<float>(0.5 * (half_to_double(low) + half_to_double(high)));
    ASSERT_EQ(float_to_half(static_cast<float>(half_to_double(low))), low);
    ASSERT_EQ(float_to_half(std::nextafter(middle, 0.0f)), low);
    ASSERT_EQ(float_to_half(std::nextafter(middle, 1e9f)), high);
    ASSERT_EQ(float_to_half(middle), (h & 1) == 0 ? low : high);
    ASSERT_EQ(float_to_half(-middle), 0x8000 | ((h & 1) == 0 ? low : high));
  }
  EXPECT_EQ(float_to_half(65519.0f), 0x7bff);
  EXPECT_EQ(float_to_half(65520.0f), 0x7c00);
  EXPECT_EQ(float_to_half(std::numeric_limits<float>::infinity()), 0x7c00);
  EXPECT_EQ(float_to_half(std::numeric_limits<float>::quiet_NaN()) & 0x7e00, 0x7e00);
}

}  // namespace
}  // namespace multum::gl
