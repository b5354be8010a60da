// SPDX-License-Identifier: Apache-2.0
// Tests the player's textures. They equal the textures of the decoder at every sample and do not depend on the number
// of threads. While images are missing, the textures have no holes and no texels of another object. Uploads stay within
// the bytes allowed per frame, and memory stays within its limit.
#include "runtime_gl/animation/field_player.h"

#include <gtest/gtest.h>

#include "host/fields/codec/field_unpacking.h"
#include "tests/gl/test_context.h"
#include "tests/unit/fields/playback/small_packed_field.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::gl {
namespace {

class FieldPlayerTest : public ::testing::TestWithParam<ContextBackend> {
 protected:
  FieldPlayerTest() : description_(testing::small_description()) {
    testing::write_packed(description_, testing::small_chunks(description_), path());
  }
  std::string path() const { return folder_ / "field.mpt"; }
  const GlFunctions& gl() const { return context_->functions(); }
  static std::vector<double> point(std::size_t sample) {
    return {static_cast<double>(sample / testing::kFieldLights), static_cast<double>(sample % testing::kFieldLights)};
  }
  /// Unpacks a layer at a sample. Returns an empty result if the sample does not have the layer.
  std::vector<float> unpacked(PackedFieldFile& file, std::size_t layer, std::size_t sample) const {
    const PackedLayer& described = description_.layers[layer];
    if (!described.is_seen(sample)) return {};
    const std::vector<int>& at = description_.field.samples[sample].at;
    const std::size_t block = described.block_at(at);
    return unpacked_texture(*file.chunk(layer, block), described.blocks[block].chunk_sample(at), "").texels;
  }
  static std::vector<float> texels(const Texture& texture) {
    std::vector<float> values;
    for (int l = 0; l < texture.shape().level_count; ++l) {
      const std::vector<float> level = texture.read_level(l);
      for (std::size_t i = 0; i < level.size(); ++i)
        if (i % 4 < 3) values.push_back(level[i]);
    }
    return values;
  }
  /// Returns the textures of all objects in the order in which the layers are drawn.
  std::vector<std::vector<float>> all_texels(const FieldPlayer& player) const {
    std::vector<std::vector<float>> all;
    for (std::size_t object = 0; object < description_.field.objects.size(); ++object)
      for (const Texture* texture : player.layers(object)) all.push_back(texels(*texture));
    return all;
  }

  testing::TemporaryFolder folder_;
  FieldDescription description_;
  std::unique_ptr<HeadlessContext> context_ = make_test_context(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Contexts, FieldPlayerTest, ::testing::ValuesIn(test_backends()),
                         [](const auto& test) { return context_backend_name(test.param); });

TEST_P(FieldPlayerTest, TexturesAreThoseOfUnpacking) {
  PackedFieldFile file(path());
  for (const bool is_linear : {false, true}) {  // whether workers make whole textures or the GPU sums images
    PlayerSettings settings;
    settings.waits = true;
    settings.is_linear = is_linear;
    FieldPlayer player(gl(), path(), settings);
    for (const std::size_t sample : {0u, 7u, 13u, 23u, 8u}) {
      SCOPED_TRACE(sample);
      const FrameReport& report = player.prepare(point(sample), {});
      std::vector<std::vector<float>> expected;
      for (std::size_t l = 0; l < 3; ++l) {
        EXPECT_EQ(report.layers[l].missing, 0u);
        auto texture = unpacked(file, l, sample);
        EXPECT_EQ(report.layers[l].is_drawn, !texture.empty());
        if (!texture.empty()) expected.push_back(std::move(texture));
      }
      const auto found = all_texels(player);
      ASSERT_EQ(found.size(), expected.size());
      EXPECT_EQ(player.mapping(1), sample / 4 < 3 ? 0u : 1u);
      for (std::size_t t = 0; t < found.size(); ++t) {
        if (!is_linear) {
          ASSERT_EQ(found[t], expected[t]);
          continue;
        }
        ASSERT_EQ(found[t].size(), expected[t].size());
        // Half floats change each image by at most 1/16, where the full range is 255. The relative change of the
        // radiance is 2.2 times as large.
        for (std::size_t i = 0; i < found[t].size(); ++i)
          ASSERT_NEAR(found[t][i], expected[t][i], 2e-3f * expected[t][i] + 2e-4f);
      }
    }
  }
}

TEST_P(FieldPlayerTest, WithoutWaitingTheCoarsestIsThereAndTheRestComes) {
  PackedFieldFile file(path());
  PlayerSettings settings;
  settings.upload_max = std::size_t{1} << 16;
  settings.playback.threads = 1;
  FieldPlayer player(gl(), path(), settings);
  SplitMix64 random(8);
  std::size_t missing = 0;
  for (int jump = 0; jump < 12; ++jump) {
    const std::size_t sample = random.next() % 24;
    for (int frame = 0; frame < 200; ++frame) {
      const FrameReport report = player.prepare(point(sample), {});
      std::size_t missing_now = 0, drawn = 0;
      for (std::size_t l = 0; l < 3; ++l) {
        EXPECT_EQ(report.layers[l].is_drawn, description_.layers[l].is_seen(sample)) << "never a hole";
        missing_now += report.layers[l].missing + (report.layers[l].is_old ? 1 : 0);
        drawn += report.layers[l].is_drawn ? 1 : 0;
      }
      // At least one image of each layer is always uploaded.
      EXPECT_LE(report.uploaded_bytes, settings.upload_max + drawn * 90 * 52 * 8);
      missing += missing_now;
      const auto shown = all_texels(player);
      ASSERT_EQ(shown.size(), drawn);
      for (const auto& texture : shown)
        for (const float value : texture) ASSERT_TRUE(value >= 0.0f && value <= 4.0f);
      if (missing_now == 0) break;
      ASSERT_LT(frame, 199) << "all comes at last";
    }
    std::size_t t = 0;
    const auto shown = all_texels(player);
    for (std::size_t l = 0; l < 3; ++l) {
      const auto expected = unpacked(file, l, sample);
      if (expected.empty()) continue;
      for (std::size_t i = 0; i < expected.size(); ++i)
        ASSERT_NEAR(shown[t][i], expected[i], 2e-3f * expected[i] + 2e-4f) << "layer " << l;
      ++t;
    }
  }
  EXPECT_GT(missing, 0u) << "no texture was ever late, so that nothing was tested";
}

TEST_P(FieldPlayerTest, AnyNumberOfThreadsGivesTheSameTextures) {
  std::vector<std::vector<std::vector<float>>> frames;
  for (const int threads : {1, 4}) {
    PlayerSettings settings;
    settings.waits = true;
    settings.is_linear = true;
    settings.playback.threads = threads;
    FieldPlayer player(gl(), path(), settings);
    std::size_t k = 0;
    for (const std::vector<double>& at :
         {std::vector<double>{0.0, 0.0}, {1.3, 2.2}, {2.6, 0.5}, {4.5, 3.0}, {9.0, -1.0}}) {
      player.prepare(at, {{5.0, 0.0}, {0.0, 3.0}});
      if (threads == 1) frames.push_back(all_texels(player));
      else EXPECT_EQ(all_texels(player), frames[k]) << "frame " << k;
      ++k;
    }
  }
}

TEST_P(FieldPlayerTest, MemoryHoldsOrIsSaidToBeTooLittle) {
  PlayerSettings settings;
  settings.waits = true;
  settings.playback.memory_max = std::size_t{2} << 20;
  FieldPlayer player(gl(), path(), settings);
  SplitMix64 random(4);
  for (int frame = 0; frame < 60; ++frame) player.prepare(point(random.next() % 24), {point(random.next() % 24)});
  EXPECT_LE(player.counts().bytes_most, settings.playback.memory_max);
  settings.is_linear = true;
  FieldDescription large = description_;  // the textures that are drawn would not fit
  large.field.objects[1].mappings[1].width = large.field.objects[1].mappings[1].height = 600;
  testing::write_packed(large, testing::small_chunks(description_), path());
  testing::expect_error(ErrorCode::kEnvironment, {"drawing takes", "allow more memory"},
                        [&] { FieldPlayer(gl(), path(), settings); });
  settings.upload_max = 10;
  testing::expect_error(ErrorCode::kUsage, {"uploads of 10 bytes"}, [&] { FieldPlayer(gl(), path(), settings); });
}

}  // namespace
}  // namespace multum::gl
