// SPDX-License-Identifier: Apache-2.0
// Tests decoding during playback. The images of a point add up to its textures, the memory stays within its limit on
// every path, and coarse images come first. Unused images are dropped after some time, and damage affects only the
// damaged chunk.
#include "host/fields/playback/field_playback.h"

#include <gtest/gtest.h>

#include <set>

#include "host/foundation/base/half_bits.h"
#include "tests/unit/fields/playback/small_packed_field.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

float half_value(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const float mantissa = static_cast<float>(bits & 1023) / 1024.0f;
  const float size = exponent == 0 ? std::ldexp(mantissa, -14) : std::ldexp(1.0f + mantissa, exponent - 15);
  return bits >> 15 != 0 ? -size : size;
}

/// Keeps the "uploaded" images, like a player that draws them.
class PlaybackTest : public ::testing::Test {
 protected:
  PlaybackTest() : description_(testing::small_description()), chunks_(testing::small_chunks(description_)) {
    testing::write_packed(description_, chunks_, path());
  }
  std::string path() const { return folder_ / "field.mpt"; }
  std::unique_ptr<FieldPlayback> open(PlaybackSettings settings = {}) {
    if (settings.threads == 0) settings.threads = 2;
    uploaded_.clear();
    return std::make_unique<FieldPlayback>(path(), settings, [this](ImageKey key) { uploaded_.erase(key); });
  }
  void upload(FieldPlayback& playback, ImageKey key) {
    if (playback.state(key) != ImageState::kDecoded) return;
    uploaded_[key] = playback.decoded(key);
    playback.uploaded(key);
  }
  /// Decodes everything that the frame needs. Returns false if there is not enough memory.
  bool decode_all(FieldPlayback& playback) {
    while (true) {
      playback.request();
      bool is_whole = true;
      for (std::size_t l = 0; l < description_.layers.size(); ++l) {
        const LayerNeed need = playback.need(l);
        is_whole = is_whole && (need.is_decoded || !need.is_drawn);
        for (const NeededImage& image : need.images) {
          upload(playback, image.key);
          is_whole = is_whole && uploaded_.count(image.key) > 0;
        }
      }
      if (is_whole) return true;
      if (!playback.wait()) return false;
    }
  }
  std::vector<float> sum(const LayerNeed& need) const {
    std::vector<float> values;
    for (const NeededImage& image : need.images) {
      const DecodedImage& decoded = uploaded_.at(image.key);
      values.resize(3 * decoded.width * decoded.height);
      for (std::size_t i = 0; i < values.size(); ++i)
        values[i] += image.weight * half_value(decoded.halves[i / 3 * 4 + i % 3]);
    }
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += need.offset[i % 3];
    return values;
  }
  std::vector<SampleShare> one(std::size_t sample) const { return {{sample, 1.0f}}; }

  testing::TemporaryFolder folder_;
  FieldDescription description_;
  std::vector<SectionSource> chunks_;
  std::map<ImageKey, DecodedImage> uploaded_;
};

TEST_F(PlaybackTest, ImagesAddUpToTheTexturesOfEverySample) {
  PackedFieldFile file(path());
  const auto playback = open();
  for (std::size_t s = 0; s < description_.field.samples.size(); ++s) {
    playback->begin_frame(one(s), {});
    ASSERT_TRUE(decode_all(*playback));
    for (std::size_t l = 0; l < description_.layers.size(); ++l) {
      const LayerNeed need = playback->need(l);
      ASSERT_EQ(need.is_drawn, l != 2 || s != 0) << "sample 0 has no texture of the last layer";
      if (!need.is_drawn) continue;
      const std::vector<int>& at = description_.field.samples[s].at;
      const std::size_t block = description_.layers[l].block_at(at);
      const auto chunk = file.chunk(l, block);
      const auto expected = chunk->texture(description_.layers[l].blocks[block].chunk_sample(at));
      const auto found = sum(need);
      ASSERT_EQ(found.size(), expected.size());
      // 16-bit floats up to 255 have a rounding error of at most 1/16, and differences have smaller errors.
      for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], 0.1f) << l << " of " << s;
    }
  }
  EXPECT_EQ(playback->counts().chunks_decoded, chunks_.size());
  EXPECT_TRUE(playback->damaged().empty());
}

TEST_F(PlaybackTest, MixedSamplesOfOneSizeAreMixed) {
  PackedFieldFile file(path());
  const auto playback = open();
  // The point is between views 3 and 4, where the ground's blocks meet. The board keeps its size.
  playback->begin_frame(sample_shares(description_.grid, {3.25, 1.5}, true), {});
  ASSERT_TRUE(decode_all(*playback));
  for (const std::size_t l : {1u, 2u}) {
    const auto texture = [&](int view, int light) {
      const std::size_t block = description_.layers[l].block_at({view, light});
      return file.chunk(l, block)->texture(description_.layers[l].blocks[block].chunk_sample({view, light}));
    };
    const auto a = texture(3, 1), b = texture(3, 2), c = texture(4, 1), d = texture(4, 2);
    const auto found = sum(playback->need(l));
    ASSERT_EQ(found.size(), a.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      ASSERT_NEAR(found[i], 0.375f * (a[i] + b[i]) + 0.125f * (c[i] + d[i]), 0.2f) << l;
  }
  // Between views 2 and 3, the texture of the board changes its size, so only the nearest view is used.
  playback->begin_frame(sample_shares(description_.grid, {2.25, 1.0}, true), {});
  ASSERT_TRUE(decode_all(*playback));
  const std::size_t block = description_.layers[2].block_at({2, 1});
  const auto nearest = file.chunk(2, block)->texture(description_.layers[2].blocks[block].chunk_sample({2, 1}));
  const auto found = sum(playback->need(2));
  ASSERT_EQ(found.size(), nearest.size());
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], nearest[i], 0.1f);
}

TEST_F(PlaybackTest, AfterAJumpSumsComeFirstAndThenTheirImages) {
  PackedFieldFile file(path());
  PlaybackSettings settings;
  settings.kind = DecodedKind::kImagesAndSums;
  settings.threads = 1;
  const auto playback = open(settings);
  for (const std::size_t sample : {5u, 22u}) {
    playback->begin_frame(one(sample), {});
    ASSERT_TRUE(decode_all(*playback));
    const auto check = [&] {
      for (std::size_t l = 0; l < 3; ++l) {
        const std::vector<int>& at = description_.field.samples[sample].at;
        const std::size_t block = description_.layers[l].block_at(at);
        const auto expected = file.chunk(l, block)->texture(description_.layers[l].blocks[block].chunk_sample(at));
        const auto found = sum(playback->need(l));
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], 0.1f) << l;
      }
    };
    check();
    EXPECT_EQ(playback->need(1).images.size(), 1u) << "one image represents the sum";
    do {  // the images are decoded anyway, because nearby frames will need them
      for (const ImageKey& key : playback->decoded_ahead()) upload(*playback, key);
      playback->request();
    } while (playback->wait());
    for (const ImageKey& key : playback->decoded_ahead()) upload(*playback, key);
    EXPECT_GE(playback->need(1).images.size(), 3u);
    check();
  }
}

TEST_F(PlaybackTest, WholeTexturesAreThoseOfUnpacking) {
  PackedFieldFile file(path());
  PlaybackSettings settings;
  settings.kind = DecodedKind::kTextures;
  const auto playback = open(settings);
  for (const std::size_t sample : {5u, 22u, 6u}) {
    playback->begin_frame(one(sample), {one(23)});
    do {
      playback->request();
    } while (playback->wait());
    for (std::size_t l = 0; l < 3; ++l) {
      const std::vector<int>& at = description_.field.samples[sample].at;
      const std::size_t block = description_.layers[l].block_at(at);
      const auto expected =
          unpacked_texture(*file.chunk(l, block), description_.layers[l].blocks[block].chunk_sample(at), "").texels;
      const LayerNeed need = playback->need(l);
      ASSERT_EQ(need.images.size(), 1u);
      ASSERT_TRUE(need.is_decoded);
      if (playback->state(need.images[0].key) == ImageState::kUploaded) continue;  // the diffuse image of sample 6
      const DecodedImage& found = playback->decoded(need.images[0].key);
      EXPECT_EQ(playback->object_of(need.images[0].key).mapping, need.mapping);
      ASSERT_EQ(found.halves.size() / 4, expected.size() / 3);
      for (std::size_t i = 0; i < expected.size(); ++i)
        ASSERT_EQ(found.halves[i / 3 * 4 + i % 3], clamped_to_half(expected[i])) << l;
      playback->uploaded(need.images[0].key);
    }
  }
}

TEST_F(PlaybackTest, ForgettingAllBeginsAnew) {
  for (const DecodedKind kind : {DecodedKind::kImages, DecodedKind::kTextures}) {
    PlaybackSettings settings;
    settings.kind = kind;
    const auto playback = open(settings);
    std::size_t decoded = 0;
    for (int round = 1; round <= 3; ++round) {
      playback->begin_frame(one(7), {one(8), one(20)});
      playback->request();
      if (round == 2) playback->forget_all();  // while workers are busy
      playback->begin_frame(one(7), {});
      do {
        playback->request();
      } while (playback->wait());
      EXPECT_EQ(playback->need(1).is_decoded, true);
      if (round == 1) decoded = playback->counts().images_decoded;
      playback->forget_all();
      EXPECT_EQ(playback->counts().bytes, 0u);
      EXPECT_EQ(playback->state({0, 0}), ImageState::kAbsent);
    }
    EXPECT_GE(playback->counts().images_decoded, 3 * decoded / 2);
    EXPECT_GT(decoded, 0u);
  }
}

TEST_F(PlaybackTest, MemoryIsNeverExceededHoweverOneWanders) {
  PlaybackSettings settings;
  settings.memory_max = std::size_t{4} << 20;
  const std::size_t drawing = settings.memory_max - 1600000;  // the remaining memory holds only some images
  for (const int threads : {1, 3}) {
    settings.threads = threads;
    const auto playback = open(settings);
    playback->reserve(drawing);
    SplitMix64 random(5);
    for (int frame = 0; frame < 300; ++frame) {
      std::vector<std::vector<SampleShare>> ahead;
      for (int d = 0; d < 4; ++d) ahead.push_back(one(random.next() % 24));
      playback->begin_frame(one(random.next() % 24), ahead);
      if (frame % 3 == 0) {
        ASSERT_TRUE(decode_all(*playback)) << "frame " << frame;
      } else {
        playback->request();
        for (const ImageKey& key : playback->decoded_ahead()) upload(*playback, key);
      }
      std::size_t kept = drawing;
      for (const auto& [key, image] : uploaded_) kept += image.halves.size() * sizeof(std::uint16_t);
      ASSERT_LE(kept, playback->counts().bytes);
    }
    EXPECT_TRUE(playback->damaged().empty());
    const PlaybackCounts counts = playback->counts();
    EXPECT_LE(counts.bytes_most, settings.memory_max);
    EXPECT_GT(counts.bytes_most, settings.memory_max - 100000) << "nearly all was used";
    EXPECT_GT(counts.forgotten, 50u);
  }
}

// A chunk whose images once did not fit into memory is later dropped like any other chunk.
TEST_F(PlaybackTest, WhatFoundNoRoomIsForgottenToo) {
  const auto bytes_in_the_end = [&](FieldPlayback& playback) {
    for (int frame = 0; frame < 4000; ++frame) {
      playback.begin_frame(one(0), {});
      EXPECT_TRUE(decode_all(playback));
    }
    return playback.counts().bytes;
  };
  PlaybackSettings settings;
  settings.threads = 1;
  settings.lifetime = 10.0;
  const auto ample = open(settings);
  for (std::size_t sample = 0; sample < 24; ++sample) {
    ample->begin_frame(one(sample), {});
    ASSERT_TRUE(decode_all(*ample));
  }
  const std::size_t expected = bytes_in_the_end(*ample);
  settings.memory_max = std::size_t{4} << 20;
  const std::size_t drawing = settings.memory_max - 1600000;
  const auto narrow = open(settings);
  narrow->reserve(drawing);
  for (std::size_t sample = 0; sample < 24; ++sample) {
    narrow->begin_frame(one(sample), {one((sample + 7) % 24), one((sample + 13) % 24), one((sample + 19) % 24)});
    ASSERT_TRUE(decode_all(*narrow));
  }
  EXPECT_EQ(bytes_in_the_end(*narrow) - drawing, expected);
}

TEST_F(PlaybackTest, TooLittleMemoryIsSaidAndNothingHangs) {
  PlaybackSettings settings;
  settings.memory_max = std::size_t{1} << 20;
  const auto playback = open(settings);
  playback->reserve((std::size_t{1} << 20) - 50000);
  playback->begin_frame(one(5), {});
  EXPECT_FALSE(decode_all(*playback));
  testing::expect_error(ErrorCode::kEnvironment, {"60000 bytes", "more memory"}, [&] { playback->reserve(60000); });
}

TEST_F(PlaybackTest, CoarseImagesComeFirst) {
  PlaybackSettings settings;
  settings.threads = 1;
  const auto playback = open(settings);
  playback->begin_frame(one(6), {one(7), one(23)});
  std::vector<std::size_t> orders;  // the frame in which its images arrived
  std::set<ImageKey> seen;
  while (true) {
    playback->request();
    for (std::size_t l = 0; l < 3; ++l) {
      const LayerNeed need = playback->need(l);
      for (std::size_t i = 0; i < need.images.size(); ++i)
        if (playback->state(need.images[i].key) == ImageState::kDecoded && seen.insert(need.images[i].key).second &&
            need.is_decoded)
          orders.push_back(i);
    }
    if (!playback->wait()) break;
  }
  ASSERT_GT(orders.size(), 6u);
  // Chunks are decoded one after another, and images of decoded chunks may come before other chunks.
  EXPECT_EQ(orders.front(), 0u);
  EXPECT_GT(orders.back(), 0u);
  EXPECT_FALSE(playback->decoded_ahead().empty());
}

TEST_F(PlaybackTest, ImagesAreForgottenByTheirLevels) {
  PlaybackSettings settings;
  settings.lifetime = 2.0;
  settings.lifetime_factor = 4.0;
  const auto playback = open(settings);
  playback->begin_frame(one(0), {});  // a block of 4 x 4 samples of the ground's second layer, with levels of 1, 4 and
                                      // 16 images
  ASSERT_TRUE(decode_all(*playback));
  std::vector<ImageKey> keys;
  for (const NeededImage& image : playback->need(1).images) keys.push_back(image.key);
  ASSERT_EQ(keys.size(), 3u);
  std::vector<int> gone(3, 0);
  for (int frame = 1; frame < 60; ++frame) {
    playback->begin_frame(one(20), {});  // view 5, another block
    for (std::size_t i = 0; i < 3; ++i)
      if (gone[i] == 0 && playback->state(keys[i]) == ImageState::kAbsent) gone[i] = frame;
  }
  // The images were last used in frame 0. Each stays for a b^l frames, which are 2 4^2, 2 4 and 2 frames here.
  EXPECT_EQ(gone, (std::vector<int>{33, 9, 3}));
}

TEST_F(PlaybackTest, WhatNobodyWantsIsCancelled) {
  PlaybackSettings settings;
  settings.threads = 1;
  const auto playback = open(settings);
  for (int frame = 0; frame < 40; ++frame) {
    playback->begin_frame(one(frame % 2 == 0 ? 0 : 23), {one(frame % 2 == 0 ? 5 : 18)});
    playback->request();
  }
  const PlaybackCounts counts = playback->counts();
  EXPECT_GT(counts.cancelled, 0u);
  playback->begin_frame(one(13), {});
  EXPECT_TRUE(decode_all(*playback)) << "everything is decoded again if it is needed";
}

TEST_F(PlaybackTest, ADamagedChunkCostsItsBlockAlone) {
  auto chunks = chunks_;
  chunks[2].bytes[chunks[2].bytes.size() / 2] ^= 0x55;  // the ground's second layer, views 4 and 5
  chunks[2].bytes.resize(chunks[2].bytes.size() / 2);   // with a valid checksum
  testing::write_packed(description_, chunks, path());
  const auto playback = open();
  for (const std::size_t sample : {0u, 23u, 3u}) {
    playback->begin_frame(one(sample), {});
    ASSERT_TRUE(decode_all(*playback));
    EXPECT_EQ(playback->need(1).is_drawn, sample != 23u);
    EXPECT_TRUE(playback->need(0).is_drawn);
    EXPECT_EQ(playback->need(2).is_drawn, sample != 0u);
  }
  ASSERT_EQ(playback->damaged().size(), 1u);
  testing::expect_says(playback->damaged()[0], {"section 3", "layer 'glossy' of object 'ground'", "damaged"});
}

TEST_F(PlaybackTest, StrangersBytesNeverExceedMemoryNorHang) {
  SplitMix64 random(99);
  PlaybackSettings settings;
  settings.memory_max = std::size_t{4} << 20;
  std::size_t left_out = 0;
  for (int round = 0; round < 60; ++round) {
    auto chunks = chunks_;
    for (auto& chunk : chunks)
      if (round % 2 == 0) chunk.bytes = damaged(chunk.bytes, random);
      else chunk.bytes[random.next() % 40] = static_cast<std::uint8_t>(random.next());  // in the head
    testing::write_packed(description_, chunks, path());
    const auto playback = open(settings);
    for (const std::size_t sample : {0u, 10u, 23u}) {
      playback->begin_frame(one(sample), {one(sample)});
      decode_all(*playback);
    }
    EXPECT_LE(playback->counts().bytes_most, settings.memory_max);
    left_out += playback->damaged().size();
  }
  EXPECT_GT(left_out, 60u);
}

TEST_F(PlaybackTest, ClosingAtOnceCancels) {
  for (int round = 0; round < 20; ++round) {
    const auto playback = open();
    playback->begin_frame(one(5), {one(23)});
    playback->request();
  }
}

TEST_F(PlaybackTest, SettingsAreChecked) {
  PlaybackSettings settings;
  settings.memory_max = 1000;
  testing::expect_error(ErrorCode::kUsage, {"1000 bytes"}, [&] { open(settings); });
  settings = {};
  settings.lifetime = -1.0;
  testing::expect_error(ErrorCode::kUsage, {"lifetime"}, [&] { open(settings); });
  settings = {};
  settings.lifetime_factor = 0.5;
  testing::expect_error(ErrorCode::kUsage, {"factor"}, [&] { open(settings); });
}

}  // namespace
}  // namespace multum
