// SPDX-License-Identifier: Apache-2.0
// Tests chunks. For every pyramid, the decoded textures of a block of parameters are within the expected error.
// Damaged, cut and hostile chunks are refused or decode to some texture.
#include <gtest/gtest.h>

#include "host/fields/codec/chunk_choice.h"
#include "host/fields/codec/colour_axes.h"
#include "host/fields/codec/symmetric_eigenvectors.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum {
namespace {

constexpr std::size_t kChunkWidth = 45, kChunkHeight = 26, kChunkTexels = kChunkWidth * kChunkHeight;

/// Makes green textures that drift with the first parameter and brighten with the second.
ChunkSource test_source(std::vector<std::size_t> sizes, std::uint64_t seed) {
  SplitMix64 random(seed);
  ChunkSource source;
  source.width = kChunkWidth;
  source.height = kChunkHeight;
  source.sizes = std::move(sizes);
  std::size_t count = 1;
  for (const std::size_t size : source.sizes) count *= size;
  const std::size_t last = source.sizes.back();
  for (std::size_t s = 0; s < count; ++s) {
    const auto plane = test_plane(kChunkWidth, kChunkHeight, 0.2 * static_cast<double>(s / last), 3.0, random);
    std::vector<float> texture(3 * kChunkTexels);
    const float gain = 0.7f + 0.3f * static_cast<float>(s % last) / static_cast<float>(last);
    for (std::size_t i = 0; i < kChunkTexels; ++i) {
      texture[3 * i] = 0.3f * gain * plane[i] + 20.0f;
      texture[3 * i + 1] = gain * plane[i];
      texture[3 * i + 2] = 0.2f * gain * plane[i] + 5.0f * static_cast<float>(random.uniform());
    }
    source.textures.push_back(std::move(texture));
  }
  source.texel_weights.assign(kChunkTexels, 1.0f);
  return source;
}

CoefficientWeights even_weights(ImageCoder coder, std::size_t side) {
  const BlockGrid grid{kChunkWidth, kChunkHeight, side};
  const std::size_t coefficients = coder == ImageCoder::kDct ? grid.count() * side * side : kChunkTexels;
  return [coefficients](std::size_t) { return std::vector<float>(coefficients, 1.0f); };
}

EncodedChunk encode_chunk(const ChunkSource& source, const ChunkSettings& settings) {
  return ChunkEncoder(source, even_weights(settings.coder, settings.side), settings.coder, settings.side)
      .encode(settings, [] {});
}

double error_of(const TextureChunk& chunk, const ChunkSource& source) {
  double error = 0.0;
  for (std::size_t s = 0; s < source.textures.size(); ++s)
    error += mean_square(chunk.texture(s), source.textures[s]) / static_cast<double>(source.textures.size());
  return error;
}

std::unique_ptr<TextureChunk> decoded(const std::vector<std::uint8_t>& bytes) {
  std::string problem;
  auto chunk = TextureChunk::decode(bytes, problem);
  EXPECT_NE(chunk, nullptr) << problem;
  return chunk;
}

TEST(TextureChunk, ErrorStaysWithinWhatWasPaidFor) {
  for (const ImageCoder coder : {ImageCoder::kDct, ImageCoder::kWavelet})
    for (const auto& sizes : std::vector<std::vector<std::size_t>>{{4, 4}, {5}, {3, 2, 2}}) {
      ChunkSettings settings;
      settings.coder = coder;
      settings.side = 8;
      settings.levels = plain_levels(sizes);
      const ChunkSource source = test_source(sizes, 11);
      std::size_t bytes_before = 0;
      double error_before = 1e9;
      for (const double lambda : {300.0, 20.0, 1.0}) {
        settings.lambda = lambda;
        const auto bytes = encode_chunk(source, settings).bytes;
        const auto chunk = decoded(bytes);
        EXPECT_FALSE(chunk->was_cut_short());
        const double error = error_of(*chunk, source);
        EXPECT_GT(bytes.size(), bytes_before);
        EXPECT_LT(error, error_before);
        bytes_before = bytes.size();
        error_before = error;
      }
      // In a closed loop, the finest level has only the error of its own quantizer, whatever the errors of the coarser
      // levels are. The quantizer's step is at most 3.5 sqrt(lambda), and a smaller coefficient may be dropped.
      EXPECT_LT(error_before, 3.5 * 3.5);
    }
}

TEST(TextureChunk, PyramidsShareWhatSamplesHaveInCommon) {
  const std::vector<std::size_t> sizes = {4, 4};
  const ChunkSource source = test_source(sizes, 12);
  ChunkSettings settings;
  settings.side = 8;
  settings.lambda = 60.0;
  const auto cost = [&](const std::vector<ParameterPyramid::Halvings>& levels) {
    settings.levels = levels;
    const auto bytes = encode_chunk(source, settings).bytes;
    return error_of(*decoded(bytes), source) * 3.0 * static_cast<double>(kChunkTexels) * 16.0 +
           8.0 * settings.lambda * static_cast<double>(bytes.size());
  };
  const double alone = cost({{0, 0}}), plain = cost(plain_levels(sizes));
  EXPECT_LT(plain, 0.9 * alone);
  const auto chosen = chosen_levels(sizes, cost);
  EXPECT_LE(cost(chosen), plain * 1.02);
}

TEST(TextureChunk, LinearReconstructionFollowsRampsBetter) {
  ChunkSource source = test_source({8}, 13);
  for (std::size_t s = 0; s < 8; ++s)
    for (auto& value : source.textures[s]) value = 40.0f + 10.0f * static_cast<float>(s);
  ChunkSettings settings;
  settings.side = 8;
  settings.lambda = 5000.0;
  settings.levels = {{3}, {2}, {1}, {0}};
  const auto nearest = error_of(*decoded(encode_chunk(source, settings).bytes), source);
  settings.linear = true;
  const auto bytes = encode_chunk(source, settings).bytes;
  const auto chunk = decoded(bytes);
  EXPECT_TRUE(chunk->format().linear);
  EXPECT_LT(error_of(*chunk, source), nearest);
}

TEST(TextureChunk, ErrorIsWhatIsLeft) {
  // Blocks reach beyond the texture's borders. The encoder's error includes the texels there, and `left` does not.
  for (const ImageCoder coder : {ImageCoder::kDct, ImageCoder::kWavelet}) {
    const ChunkSource source = test_source({2, 2}, 21);
    ChunkSettings settings;
    settings.coder = coder;
    settings.side = 8;
    settings.lambda = 20.0;
    settings.levels = plain_levels(source.sizes);
    const EncodedChunk chunk = encode_chunk(source, settings);
    const double left = 4.0 * 3.0 * static_cast<double>(kChunkTexels) * error_of(*decoded(chunk.bytes), source);
    EXPECT_NEAR(chunk.error / left, 1.1, 0.15);
  }
}

TEST(BestChunk, IsNoWorseThanAnyCandidateOfTheFirstCoder) {
  const ChunkSource source = test_source({4, 2}, 22);
  ChunkCandidates candidates;
  candidates.coders = {{ImageCoder::kDct, 8}, {ImageCoder::kDct, 16}, {ImageCoder::kWavelet, 16}};
  candidates.pyramids = {plain_levels({4, 2}), {{2, 1}, {0, 1}, {0, 0}}, {{0, 0}}};
  candidates.basis_images = {1, 2, 4};
  const double lambda = 40.0;
  const ChosenChunk chosen = best_chunk(source, even_weights, candidates, lambda, [] {});
  const EncodedChunk& best = chosen.chunk;
  EXPECT_EQ(encode_chunk(source, chosen.settings).bytes, best.bytes)
      << "the chosen settings must give the same bytes again";
  ChunkSettings settings;
  settings.side = 8;
  settings.lambda = lambda;
  for (const auto& levels : candidates.pyramids) {
    settings.levels = levels;
    EXPECT_LE(best.cost(lambda), encode_chunk(source, settings).cost(lambda));
  }
  settings.levels.clear();
  settings.basis_images = 1;
  EXPECT_LE(best.cost(lambda), encode_chunk(source, settings).cost(lambda));
  EXPECT_NE(decoded(best.bytes), nullptr);
}

TEST(BestChunk, TriesWhatItIsAskedTo) {
  const std::vector<std::size_t> sizes = {4, 2};
  const ChunkSource source = test_source(sizes, 23);
  const double lambda = 40.0;
  const auto cost = [&](PyramidChoice pyramid, std::optional<ImageCoder> coder) {
    const auto candidates = chunk_candidates(sizes, pyramid, coder, false);
    const ChosenChunk chosen = best_chunk(source, even_weights, candidates, lambda, [] {});
    const std::vector<ParameterPyramid::Halvings> alone = {{0, 0}};
    EXPECT_EQ(decoded(chosen.chunk.bytes)->format().coder, coder.value_or(chosen.settings.coder));
    EXPECT_TRUE(pyramid != PyramidChoice::kPlain || chosen.settings.levels == plain_levels(sizes));
    EXPECT_TRUE(pyramid != PyramidChoice::kNone || chosen.settings.levels == alone);
    return chosen.chunk.cost(lambda);
  };
  const double plain = cost(PyramidChoice::kPlain, {}), none = cost(PyramidChoice::kNone, {});
  EXPECT_LT(plain, none) << "the samples are similar";
  EXPECT_LE(cost(PyramidChoice::kAdaptive, {}), plain);
  EXPECT_LT(cost(PyramidChoice::kGreedy, {}), none);
  for (const ImageCoder coder : {ImageCoder::kDct, ImageCoder::kWavelet})
    EXPECT_GE(cost(PyramidChoice::kPlain, coder), plain);
}

// Finer images cannot repair the coding errors of coarser images, so the error of each level stays in the sum.
TEST(TextureChunk, AnOpenLoopLeavesMoreError) {
  const ChunkSource source = test_source({4, 4}, 24);
  ChunkSettings settings;
  settings.side = 8;
  settings.lambda = 2.0;
  settings.levels = plain_levels(source.sizes);
  const EncodedChunk closed = encode_chunk(source, settings);
  settings.open_loop = true;
  const EncodedChunk open = encode_chunk(source, settings);
  EXPECT_GT(open.cost(settings.lambda), 1.02 * closed.cost(settings.lambda));
  const double left = 16.0 * 3.0 * static_cast<double>(kChunkTexels) * error_of(*decoded(open.bytes), source);
  EXPECT_NEAR(open.error / left, 1.1, 0.15) << "the encoder knows";
}

TEST(TextureChunk, ALearntBasisFollowsWhatDimsAndBrightens) {
  // The samples are multiples of one texture. A basis needs only one image, whereas a pyramid also needs differences.
  ChunkSource source = test_source({8}, 18);
  for (std::size_t s = 1; s < 8; ++s)
    for (std::size_t i = 0; i < source.textures[s].size(); ++i)
      source.textures[s][i] = source.textures[0][i] * (0.4f + 0.08f * static_cast<float>(s));
  ChunkSettings settings;
  settings.side = 8;
  settings.lambda = 30.0;
  settings.levels = plain_levels(source.sizes);
  const auto pyramid = encode_chunk(source, settings).bytes;
  settings.levels.clear();
  settings.basis_images = 3;
  const auto basis = encode_chunk(source, settings).bytes;
  const auto chunk = decoded(basis);
  EXPECT_EQ(chunk->format().basis.size(), 3u);
  EXPECT_LT(basis.size(), 0.8 * static_cast<double>(pyramid.size()));
  EXPECT_LT(error_of(*chunk, source), error_of(*decoded(pyramid), source));
}

TEST(TextureChunk, ALearntBasisOfAllImagesLosesNothing) {
  const ChunkSource source = test_source({2, 3}, 19);
  ChunkSettings settings;
  settings.coder = ImageCoder::kWavelet;
  settings.lambda = 0.05;
  settings.basis_images = 100;  // at most one image per sample
  const auto chunk = decoded(encode_chunk(source, settings).bytes);
  EXPECT_EQ(chunk->format().basis.size(), 6u);
  EXPECT_LT(error_of(*chunk, source), 0.5);
}

TEST(SymmetricEigenvectors, DiagonalizeAndAreSorted) {
  SplitMix64 random(20);
  for (const std::size_t n : {1, 2, 5, 30}) {
    std::vector<double> matrix(n * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) matrix[i * n + j] = matrix[j * n + i] = random.uniform() - 0.5;
    const auto vectors = symmetric_eigenvectors(matrix, n);
    double before = 1e9;
    for (std::size_t k = 0; k < n; ++k) {
      double value = 0.0;
      std::vector<double> image(n);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) image[i] += matrix[i * n + j] * vectors[k][j];
      for (std::size_t i = 0; i < n; ++i) value += image[i] * vectors[k][i];
      for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(image[i], value * vectors[k][i], 1e-10);
      EXPECT_LE(value, before + 1e-12);
      before = value;
    }
  }
}

TEST(TextureChunk, SameBytesEveryTime) {
  const ChunkSource source = test_source({3, 3}, 14);
  ChunkSettings settings;
  settings.levels = plain_levels(source.sizes);
  EXPECT_EQ(encode_chunk(source, settings).bytes, encode_chunk(source, settings).bytes);
}

/// Makes chunks of both coders, with a pyramid, a linear pyramid, and a basis.
std::vector<std::vector<std::uint8_t>> chunks_of_all_kinds() {
  std::vector<std::vector<std::uint8_t>> chunks;
  for (const ImageCoder coder : {ImageCoder::kDct, ImageCoder::kWavelet})
    for (const int kind : {0, 1, 2}) {
      ChunkSettings settings;
      settings.coder = coder;
      settings.lambda = 3000.0;  // some images do not get any coefficients
      settings.linear = kind == 1;
      if (kind < 2) settings.levels = {{2, 2}, {0, 2}, {0, 0}};
      chunks.push_back(encode_chunk(test_source({4, 3}, 17), settings).bytes);
    }
  return chunks;
}

TEST(TextureChunk, ImagesAddUpToTextures) {
  int zeros = 0;
  for (const auto& bytes : chunks_of_all_kinds()) {
    const auto chunk = decoded(bytes);
    std::vector<std::vector<float>> images;
    for (std::size_t i = 0; i < chunk->plan().image_count(); ++i) {
      images.push_back(chunk->image(i));
      const bool is_zero = std::all_of(images[i].begin(), images[i].end(), [](float value) { return value == 0.0f; });
      EXPECT_EQ(chunk->is_zero(i), is_zero) << i;
      zeros += is_zero;
    }
    const auto offset = chunk->format().offset_colour();
    for (std::size_t s = 0; s < chunk->sample_count(); ++s) {
      std::vector<float> sum(3 * kChunkTexels);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = offset[i % 3];
      for (const auto& term : chunk->plan().of_samples[s])
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += term.weight * images[term.image][i];
      const auto texture = chunk->texture(s);
      for (std::size_t i = 0; i < sum.size(); ++i) ASSERT_NEAR(sum[i], texture[i], 1e-3f) << "sample " << s;
    }
  }
  EXPECT_GT(zeros, 0) << "no chunk had an image without coefficients";
}

TEST(TextureChunk, LimitsAreKept) {
  for (const auto& bytes : chunks_of_all_kinds()) {
    std::string problem;
    const std::size_t needed = decoded(bytes)->memory_bytes();
    ASSERT_GT(needed, 100u);
    // During decoding, wavelet planes take up to three times eight bytes per texel for two more images, and vectors of
    // cosine coefficients grow.
    DecodingLimits limits;
    limits.bytes_max = 4 * needed + 2 * 24 * kChunkTexels;
    EXPECT_NE(TextureChunk::decode(bytes, problem, limits), nullptr) << problem;
    limits.bytes_max = needed - 1;
    bool ran_out = false;
    limits.ran_out = &ran_out;
    EXPECT_EQ(TextureChunk::decode(bytes, problem, limits), nullptr);
    EXPECT_TRUE(ran_out);
    EXPECT_EQ(problem, "its coefficients take more than " + std::to_string(needed - 1) + " bytes");
    const std::atomic<bool> cancelled{true};
    ran_out = false;
    limits = {SIZE_MAX, &cancelled, &ran_out};
    EXPECT_EQ(TextureChunk::decode(bytes, problem, limits), nullptr);
    EXPECT_FALSE(ran_out);
    EXPECT_EQ(problem, "its decoding was cancelled");
  }
}

TEST(TextureChunk, DamagedChunksAreRefusedOrDecode) {
  for (const int kind : {0, 1, 2, 3}) {
    const ImageCoder coder = kind % 2 == 0 ? ImageCoder::kDct : ImageCoder::kWavelet;
    ChunkSettings settings;
    settings.coder = coder;
    settings.lambda = 30.0;
    if (kind < 2) settings.levels = {{2, 2}, {0, 2}, {0, 0}};
    const auto bytes = encode_chunk(test_source({4, 3}, 15), settings).bytes;
    for (std::size_t cut = 0; cut < bytes.size(); cut += 1 + cut / 8) {
      std::string problem;
      const auto chunk = TextureChunk::decode(std::span<const std::uint8_t>(bytes).first(cut), problem);
      if (chunk == nullptr) {
        EXPECT_FALSE(problem.empty());
      } else EXPECT_TRUE(chunk->was_cut_short());
    }
    SplitMix64 random(16);
    int refused = 0;
    for (int round = 0; round < 400; ++round) {
      std::vector<std::uint8_t> other;
      if (round % 2 == 0) {
        other = damaged(bytes, random);
      } else {  // damages only the header, which random damage to large streams rarely reaches
        other = bytes;
        other[random.next() % 45] = static_cast<std::uint8_t>(random.next());
      }
      std::string problem;
      const auto chunk = TextureChunk::decode(other, problem);
      if (chunk == nullptr) {
        ++refused;
        EXPECT_FALSE(problem.empty());
      } else if (chunk->format().width * chunk->format().height < 100000) {
        chunk->texture(chunk->sample_count() - 1);
      }
    }
    EXPECT_GT(refused, 10);
  }
}

TEST(TextureChunk, RefusesWhatWouldTakeTooMuch) {
  // With 16384 x 16384 texels and 65536 samples, this header would make a decoder allocate petabytes.
  const std::vector<std::uint8_t> head = {0, 0x80, 0x80, 1, 0x80, 0x80, 1, 1, 1, 0x80, 0x80, 4, 0, 64, 16};
  std::string problem;
  EXPECT_EQ(TextureChunk::decode(head, problem), nullptr);
  EXPECT_EQ(problem, "the images have more than 2^28 texels in total");
  // This header claims one texel and 4^8 samples, with 2^8 images on each of 32 levels.
  std::vector<std::uint8_t> sums = {2, 1, 1, 8, 32};
  sums.insert(sums.end(), 8, 4);
  sums.insert(sums.end(), 32 * 9, 0);
  EXPECT_EQ(TextureChunk::decode(sums, problem), nullptr);
  EXPECT_EQ(problem, "the samples are sums of more than 2^22 images in total");
}

TEST(ColourAxes, FindTheLongestAxisAndRotate) {
  SplitMix64 random(17);
  for (int round = 0; round < 50; ++round) {
    const double along[3] = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    std::vector<float> texture(300);
    for (std::size_t i = 0; i < 100; ++i) {
      const double t = 200.0 * (random.uniform() - 0.5);
      for (std::size_t c = 0; c < 3; ++c)
        texture[3 * i + c] = static_cast<float>(100.0 + t * along[c] + random.uniform());
    }
    TextureChunkFormat format;
    format.rotation = colour_axes({texture}, std::vector<float>(100, 1.0f)).quaternion;
    const auto rows = format.rotation_rows();
    double dot = 0.0, length = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      dot += static_cast<double>(rows[0][c]) * along[c];
      length += along[c] * along[c];
    }
    EXPECT_GT(std::abs(dot) / std::sqrt(length), 0.98);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        double product = 0.0;
        for (std::size_t c = 0; c < 3; ++c)
          product += static_cast<double>(rows[i][c]) * static_cast<double>(rows[j][c]);
        EXPECT_NEAR(product, i == j ? 1.0 : 0.0, 1e-6);
      }
  }
  EXPECT_EQ(colour_axes({std::vector<float>(3)}, {0.0f}).quaternion, (std::array<std::int16_t, 4>{32767, 0, 0, 0}));
}

}  // namespace
}  // namespace multum
