// SPDX-License-Identifier: Apache-2.0
// Tests the two image coders. The decoder gets exactly the image that the encoder predicts, streams may be cut
// anywhere, and unseen texels take almost no bytes.
#include <gtest/gtest.h>

#include <numeric>

#include "host/fields/codec/dct_stream_encoder.h"
#include "host/fields/codec/wavelet_stream_encoder.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

constexpr std::size_t kWidth = 70, kHeight = 37, kTexels = kWidth * kHeight;

struct Picture {
  std::array<std::vector<float>, 3> planes;
};

/// Makes two similar pictures, a picture of noise, a picture with extreme values, and an empty picture.
std::vector<Picture> pictures(SplitMix64& random) {
  std::vector<Picture> result(4);
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t p = 0; p < 3; ++p) {
      auto& plane = result[k].planes[p];
      plane = test_plane(kWidth, kHeight, static_cast<double>(p), k == 1 ? 100.0 : 2.0, random);
      if (k == 2)
        std::transform(plane.begin(), plane.end(), plane.begin(), [](float v) { return v > 170.0f ? 1e8f : 0.0f; });
      if (k == 3) std::fill(plane.begin(), plane.end(), 0.0f);
    }
  return result;
}

struct DctResult {
  std::vector<CoefficientBlocks> images;
  std::vector<std::uint8_t> bytes;
};

DctResult dct_encoded(const BlockGrid& grid, const std::vector<Picture>& source, float scale, float lambda,
                      std::vector<float> weights = {}) {
  DctStreamEncoder encoder(grid);
  DctResult result;
  for (std::size_t k = 0; k < source.size(); ++k) {
    DctTarget target;
    for (std::size_t p = 0; p < 3; ++p) target.coefficients[p] = block_coefficients(grid, source[k].planes[p]);
    target.weights = weights.empty() ? std::vector<float>(grid.count() * grid.side * grid.side, 1.0f) : weights;
    target.steps.assign(grid.side * grid.side, 1.0f);
    target.scale = scale;
    target.lambda = lambda;
    auto& images = result.images;
    auto image = encoder.add_image(target, k > 0 ? &images[0] : nullptr, k > 0 ? &images[k - 1] : nullptr, k);
    images.push_back(std::move(image));
  }
  result.bytes = encoder.finish();
  return result;
}

bool same(const CoefficientBlocks& a, const CoefficientBlocks& b) {
  for (std::size_t p = 0; p < 3; ++p)
    for (std::size_t i = 0; i < a.block_count(); ++i) {
      const auto x = a.block(p, i), y = b.block(p, i);
      if (!std::equal(x.begin(), x.end(), y.begin(), y.end())) return false;
    }
  return true;
}

TEST(DctStream, DecoderHasWhatTheEncoderSays) {
  for (const std::size_t side : {8, 16, 32}) {
    SplitMix64 random(side);
    const BlockGrid grid{kWidth, kHeight, side};
    const auto coded = dct_encoded(grid, pictures(random), 6.0f, 4.0f);
    DctStreamDecoder decoder(grid, coded.bytes);
    std::vector<CoefficientBlocks> images;
    for (std::size_t k = 0; k < coded.images.size(); ++k) {
      auto image = decoder.next_image(k > 0 ? &images[0] : nullptr, k > 0 ? &images[k - 1] : nullptr, k);
      images.push_back(std::move(image));
      EXPECT_TRUE(same(images[k], coded.images[k])) << side << ' ' << k;
    }
    EXPECT_FALSE(decoder.exhausted());
  }
}

double dct_error(const BlockGrid& grid, const CoefficientBlocks& image, const Picture& picture, float scale) {
  const std::vector<float> steps(grid.side * grid.side, 1.0f);
  constexpr std::array<std::array<float, 3>, 3> kPlanesAlone = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::vector<float> colours(3 * kTexels);
  add_colours(std::array{WeighedImage{&image, scale}}, grid, steps, kPlanesAlone, colours);
  double error = 0.0;
  for (std::size_t p = 0; p < 3; ++p) {
    std::vector<float> samples(kTexels);
    for (std::size_t i = 0; i < kTexels; ++i) samples[i] = colours[3 * i + p];
    error += mean_square(samples, picture.planes[p]) / 3.0;
  }
  return error;
}

TEST(DctStream, ErrorFollowsTheStep) {
  SplitMix64 random(3);
  const BlockGrid grid{kWidth, kHeight, 8};
  auto source = pictures(random);
  source.resize(2);
  std::size_t bytes_before = 0;
  for (const float step : {32.0f, 8.0f, 2.0f}) {
    const auto coded = dct_encoded(grid, source, step, 0.0f);  // without lambda, values are simply rounded
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_LE(dct_error(grid, coded.images[k], source[k], step), static_cast<double>(step * step) / 11.0);
    EXPECT_GT(coded.bytes.size(), bytes_before);
    bytes_before = coded.bytes.size();
  }
}

TEST(DctStream, LambdaTradesErrorForBytes) {
  SplitMix64 random(4);
  const BlockGrid grid{kWidth, kHeight, 16};
  std::vector<Picture> source(1);
  for (auto& plane : source[0].planes) plane = test_plane(kWidth, kHeight, 0.0, 10.0, random);  // noise below the step
  const auto total = [&](const DctResult& coded) {  // error + lambda * bits, with lambda = 30
    const double error = 3.0 * static_cast<double>(kTexels) * dct_error(grid, coded.images[0], source[0], 16.0f);
    return error + 30.0 * 8.0 * static_cast<double>(coded.bytes.size());
  };
  const auto plain = dct_encoded(grid, source, 16.0f, 0.0f), chosen = dct_encoded(grid, source, 16.0f, 30.0f);
  EXPECT_LT(chosen.bytes.size(), plain.bytes.size());
  EXPECT_LT(total(chosen), 0.95 * total(plain));
}

TEST(DctStream, WhatNothingSeesCostsNothing) {
  SplitMix64 random(5);
  const BlockGrid grid{kWidth, kHeight, 8};
  auto source = pictures(random);
  source.resize(1);
  std::vector<float> half(grid.count() * 64, 1.0f);
  for (std::size_t b = 0; b < grid.count(); ++b)
    if (b % grid.columns() >= grid.columns() / 2)
      std::fill_n(half.begin() + static_cast<std::ptrdiff_t>(64 * b), 64, 0.0f);
  auto noisy = source;
  for (auto& plane : noisy[0].planes)
    for (std::size_t i = 0; i < kTexels; ++i)
      if (i % kWidth >= 40) plane[i] = static_cast<float>(255.0 * random.uniform());
  // Texels without weight may have any value, because no byte of the stream depends on them.
  EXPECT_EQ(dct_encoded(grid, source, 6.0f, 4.0f, half).bytes, dct_encoded(grid, noisy, 6.0f, 4.0f, half).bytes);
  EXPECT_LT(dct_encoded(grid, source, 6.0f, 4.0f, half).bytes.size(),
            dct_encoded(grid, source, 6.0f, 4.0f).bytes.size() * 6 / 10);
}

TEST(DctStream, CutAndDamagedStreamsDecode) {
  SplitMix64 random(6);
  const BlockGrid grid{kWidth, kHeight, 16};
  const auto coded = dct_encoded(grid, pictures(random), 6.0f, 4.0f);
  for (std::size_t cut = 0; cut < coded.bytes.size(); cut += 97) {
    DctStreamDecoder decoder(grid, std::span<const std::uint8_t>(coded.bytes).first(cut));
    const auto first = decoder.next_image(nullptr, nullptr, 0);
    for (std::size_t k = 1; k < 4; ++k) decoder.next_image(&first, &first, k);
    EXPECT_TRUE(decoder.exhausted());
    // Each block equals the block of the encoder. After the cut, blocks are zero.
    for (std::size_t p = 0; p < 3; ++p)
      for (std::size_t b = 0; b < grid.count(); ++b) {
        const auto x = first.block(p, b), y = coded.images[0].block(p, b);
        if (!x.empty()) {
          EXPECT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end()));
        }
      }
  }
  for (int round = 0; round < 100; ++round) {
    const auto bytes = round % 2 == 0 ? damaged(coded.bytes, random) : random_bytes(random, random.next() % 500);
    DctStreamDecoder decoder(grid, bytes);
    const auto first = decoder.next_image(nullptr, nullptr, 0);
    for (std::size_t k = 1; k < 4; ++k) decoder.next_image(&first, &first, k);
  }
}

struct WaveletResult {
  std::vector<WaveletImage> images;
  std::vector<std::uint8_t> bytes;
};

WaveletResult wavelet_encoded(std::size_t width, std::size_t height, const std::vector<Picture>& source, float scale,
                              float lambda) {
  WaveletStreamEncoder encoder(width, height);
  WaveletResult result;
  for (std::size_t k = 0; k < source.size(); ++k) {
    WaveletTarget target;
    for (std::size_t p = 0; p < 3; ++p) {
      target.coefficients[p] = source[k].planes[p];
      forward_wavelet(width, height, target.coefficients[p]);
    }
    target.weights.assign(width * height, 1.0f);
    target.steps.assign(wavelet_bands(width, height).size(), 1.0f);
    target.scale = scale;
    target.lambda = lambda;
    result.images.push_back(encoder.add_image(target, k > 0 ? &result.images[0] : nullptr));
  }
  result.bytes = encoder.finish();
  return result;
}

bool same(const WaveletImage& a, const WaveletImage& b) {
  for (std::size_t p = 0; p < 3; ++p)
    if (a[p].magnitudes != b[p].magnitudes || a[p].negative != b[p].negative || a[p].known != b[p].known) return false;
  return true;
}

TEST(WaveletStream, DecoderHasWhatTheEncoderSays) {
  for (const auto& [width, height] :
       std::vector<std::pair<std::size_t, std::size_t>>{{kWidth, kHeight}, {1, 1}, {5, 64}, {33, 8}}) {
    SplitMix64 random(width);
    auto source = pictures(random);
    for (auto& picture : source)
      for (auto& plane : picture.planes) plane.resize(width * height);
    const auto coded = wavelet_encoded(width, height, source, 6.0f, 1.0f);
    WaveletStreamDecoder decoder(width, height, coded.bytes);
    std::vector<WaveletImage> images;
    for (std::size_t k = 0; k < coded.images.size(); ++k) {
      images.push_back(decoder.next_image(k > 0 ? &images[0] : nullptr));
      EXPECT_TRUE(same(images[k], coded.images[k])) << width << ' ' << k;
    }
    EXPECT_FALSE(decoder.exhausted());
  }
}

TEST(WaveletStream, EveryPrefixDecodesAndMoreBytesLeaveLessError) {
  SplitMix64 random(8);
  auto source = pictures(random);
  source.erase(source.begin());
  source.resize(1);  // noise, so that every bit plane holds data
  const auto coded = wavelet_encoded(kWidth, kHeight, source, 4.0f, 0.0f);
  const std::vector<float> steps(wavelet_bands(kWidth, kHeight).size(), 1.0f);
  std::vector<double> errors;
  const std::size_t stride = 5;
  for (std::size_t cut = coded.bytes.size() % stride; cut <= coded.bytes.size(); cut += stride) {
    WaveletStreamDecoder decoder(kWidth, kHeight, std::span<const std::uint8_t>(coded.bytes).first(cut));
    const auto image = decoder.next_image(nullptr);
    EXPECT_EQ(decoder.exhausted(), cut < coded.bytes.size());
    double error = 0.0;
    for (std::size_t p = 0; p < 3; ++p) {
      std::vector<float> samples(kTexels);
      add_samples(image[p], steps, 4.0f, samples);
      error += mean_square(samples, source[0].planes[p]);
    }
    errors.push_back(error);
  }
  // One more byte may move a coefficient away from its true value. Such increases of the error are small, and the error
  // soon falls again.
  for (std::size_t cut = 1; cut < errors.size(); ++cut)
    EXPECT_LT(errors[cut], errors[cut - 1] + 0.004 * errors[0]) << cut;
  for (std::size_t cut = 13; cut < errors.size(); ++cut) EXPECT_LT(errors[cut], errors[cut - 13]) << cut;
  EXPECT_LT(errors.back(), 3 * 4.0 * 4.0 / 2.0);
}

TEST(WaveletStream, DamagedStreamsDecode) {
  SplitMix64 random(9);
  const auto coded = wavelet_encoded(kWidth, kHeight, pictures(random), 6.0f, 1.0f);
  for (int round = 0; round < 100; ++round) {
    const auto bytes = round % 2 == 0 ? damaged(coded.bytes, random) : random_bytes(random, random.next() % 500);
    WaveletStreamDecoder decoder(kWidth, kHeight, bytes);
    const auto first = decoder.next_image(nullptr);
    for (std::size_t k = 1; k < 4; ++k) decoder.next_image(&first);
  }
}

}  // namespace
}  // namespace multum
