// SPDX-License-Identifier: Apache-2.0
// Compares kernels/image_transform.cl, which host/fields/codec/transforms runs, with double precision and with the
// transforms of the decoder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "host/fields/codec/decoder/wavelet_transform.h"
#include "host/fields/codec/transforms/device_image_transforms.h"
#include "host/lab/field_cases/image_transform.h"
#include "tests/fixtures/random_values.h"
#include "tests/fixtures/test_device.h"

namespace multum {
namespace {

using testing::test_device;
using testing::uniform24;

using Textures = std::vector<std::vector<float>>;

Textures random_textures(const CoefficientLayout& layout, std::size_t count, std::mt19937& random) {
  Textures textures(count, std::vector<float>(3 * layout.width * layout.height));
  for (auto& texture : textures)
    for (float& value : texture) value = static_cast<float>(255.0 * uniform24(random));
  return textures;
}

// Returns a rotation by three random angles, and offsets of some hundreds.
PlaneAxes random_axes(std::mt19937& random) {
  TextureChunkFormat format;
  for (auto& part : format.rotation) part = static_cast<std::int16_t>(65000.0 * (uniform24(random) - 0.5));
  PlaneAxes axes{format.rotation_rows(), {}};
  for (float& offset : axes.offsets) offset = static_cast<float>(400.0 * (uniform24(random) - 0.5));
  return axes;
}

std::vector<double> exact_plane(const std::vector<float>& texture, const PlaneAxes& axes, std::size_t p) {
  std::vector<double> plane;
  for (std::size_t i = 0; i < texture.size(); i += 3) {
    double sum = -static_cast<double>(axes.offsets[p]);
    for (std::size_t c = 0; c < 3; ++c)
      sum += static_cast<double>(axes.rows[p][c]) * static_cast<double>(texture[i + c]);
    plane.push_back(sum);
  }
  return plane;
}

std::vector<double> exact_coefficients(const CoefficientLayout& layout, const std::vector<double>& plane) {
  return layout.coder == ImageCoder::kDct
             ? reference::block_cosines(plane, layout.width, layout.height, layout.side)
             : reference::wavelets(plane, layout.width, layout.height, wavelet_depth(layout.width, layout.height));
}

std::vector<CoefficientLayout> layouts() {
  std::vector<CoefficientLayout> all;
  for (const auto& [width, height] :
       std::vector<std::pair<std::size_t, std::size_t>>{{1, 1}, {8, 8}, {1, 40}, {21, 9}, {33, 64}, {70, 31}}) {
    for (const std::size_t side : {8, 16, 32}) all.push_back({ImageCoder::kDct, width, height, side});
    all.push_back({ImageCoder::kWavelet, width, height, 16});
  }
  return all;
}

// This is the largest error, relative to the largest magnitude in the transform of the plane. Each of two passes adds
// up 32 terms, which are rounded cosines times samples of up to 650 that may cancel. There are at most 64 roundings of
// 6e-8. Their sum is typically as large as 8 of them.
constexpr double kTransformError = 1e-6;

void expect_reference(const CoefficientLayout& layout, std::size_t count, std::mt19937& random) {
  const Textures textures = random_textures(layout, count, random);
  const PlaneAxes axes = random_axes(random);
  DeviceImageTransforms on_device(test_device());
  HostImageTransforms on_host;
  const auto found = on_device.coefficients(layout, textures, axes),
             of_host = on_host.coefficients(layout, textures, axes);
  ASSERT_EQ(found.size(), textures.size());
  for (std::size_t t = 0; t < textures.size(); ++t)
    for (std::size_t p = 0; p < 3; ++p) {
      const auto exact = exact_coefficients(layout, exact_plane(textures[t], axes, p));
      ASSERT_EQ(found[t][p].size(), exact.size());
      ASSERT_EQ(of_host[t][p].size(), exact.size());
      double most = 650.0;
      for (const double value : exact) most = std::max(most, std::abs(value));
      for (std::size_t i = 0; i < exact.size(); ++i) {
        ASSERT_NEAR(static_cast<double>(found[t][p][i]), exact[i], kTransformError * most)
            << layout.width << " x " << layout.height << ", side " << layout.side << ", coefficient " << i;
        ASSERT_NEAR(static_cast<double>(of_host[t][p][i]), exact[i], kTransformError * most);
      }
    }
}

TEST(ImageTransformTest, CoefficientsEqualTheReference) {
  std::mt19937 random(51);
  for (const CoefficientLayout& layout : layouts()) expect_reference(layout, 3, random);
}

// The textures are small enough for a simulator (tests/cli/oclgrind_test.cpp).
TEST(ImageTransformTest, CoefficientsOfASmallTextureEqualTheReference) {
  std::mt19937 random(55);
  expect_reference({ImageCoder::kDct, 9, 7, 8}, 1, random);
  expect_reference({ImageCoder::kWavelet, 9, 8, 16}, 1, random);
}

TEST(ImageTransformTest, BytesAreTheSameForAnyBatchAndAfterOtherLayouts) {
  std::mt19937 random(52);
  DeviceImageTransforms all_at_once(test_device()), one_by_one(test_device(), 1), by_threes(test_device(), 120000);
  for (const CoefficientLayout& layout : layouts()) {
    const Textures textures = random_textures(layout, 7, random);
    const PlaneAxes axes = random_axes(random);
    const auto found = all_at_once.coefficients(layout, textures, axes);
    EXPECT_EQ(one_by_one.coefficients(layout, textures, axes), found);
    EXPECT_EQ(by_threes.coefficients(layout, textures, axes), found);
    EXPECT_EQ(DeviceImageTransforms(test_device()).coefficients(layout, textures, axes), found);
  }
}

TEST(ImageTransformTest, ThreadsMayShareIt) {
  std::mt19937 random(53);
  const auto all = layouts();
  DeviceImageTransforms shared(test_device());
  std::vector<Textures> textures;
  std::vector<std::vector<PlaneCoefficients>> alone, together(all.size());
  const PlaneAxes axes = random_axes(random);
  for (const CoefficientLayout& layout : all) {
    textures.push_back(random_textures(layout, 2, random));
    alone.push_back(shared.coefficients(layout, textures.back(), axes));
  }
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < 4; ++k)
    threads.emplace_back([&, k] {
      for (std::size_t i = k; i < all.size(); i += 4) together[i] = shared.coefficients(all[i], textures[i], axes);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
}

// Each step is one launch, for any number of textures.
TEST(ImageTransformTest, TexturesOfABatchAreOneLaunch) {
  std::mt19937 random(54);
  const CoefficientLayout layout{ImageCoder::kDct, 40, 40, 16};
  DeviceImageTransforms transforms(test_device());
  const std::uint64_t before = test_device().launch_total();
  transforms.coefficients(layout, random_textures(layout, 64, random), random_axes(random));
  EXPECT_EQ(test_device().launch_total() - before, 3u);
}

}  // namespace
}  // namespace multum
