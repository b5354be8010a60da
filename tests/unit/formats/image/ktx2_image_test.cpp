// SPDX-License-Identifier: Apache-2.0
// Tests reading KTX2 files as images. multum gltf writes such files into models.
#include <gtest/gtest.h>
#include <zstd.h>

#include <array>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "host/formats/decoder/library_image_file.h"
#include "host/formats/decoder/uastc_block.h"
#include "host/formats/image/files/number_type.h"
#include "host/formats/mesh/gltf_material.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

std::vector<std::uint8_t> from_hex(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

struct UastcCase {
  const char* block;
  std::uint64_t texels;  // the FNV-1a hash of the result of unpack_uastc() in Basis Universal's transcoder
};

// For each mode from 0 to 18, there is a block of random bits. Two million other blocks also gave the same results.
constexpr UastcCase kBlocks[] = {
    {"01803cd108d88d73afea79c81e4783c6", 0x7f8bb08a820a6f37}, {"3589a9b9586df6ddf4cc526a8b692470", 0xd78e21bf0b72b606},
    {"dd1d12347a1f31e2d379ddadebb3560f", 0x740e0d2d8d2098de}, {"a3197db322962177633dce87a08343df", 0x928308b68b1299c0},
    {"7368585f1c4072d6fe3a587f33960a6b", 0xec7e3a86e87d7150}, {"8bbdfbfa0e681e88a8b09e97c2dcc0e7", 0xa0cf7b691c5c46c7},
    {"7b44970ebf15ae7c83b858d0ae36cf47", 0x99de4c2dd0ad8753}, {"47e7b0360f8591aa1476b016e58df172", 0x1d924a62668cb037},
    {"d7d7e9f1f7de60568de989073f3d1639", 0xbc7daaa556421285}, {"0f40c4196fe2d7871a99681609c3e77e", 0x9beff423c584bfea},
    {"52736182ecdc67620ab660e952d6c6c2", 0x20a64e96cf8e0656}, {"f8fdcd0634d5c6024cdb95cb074dc84b", 0xfe0c121354b56cc4},
    {"8619b214fe6592d48bfcea9c9d8e3244", 0x4181954af8da9828}, {"1ff40967869e43928c494a5bc1d535aa", 0xd20f39dea7325135},
    {"6d63200854cd324fa9406cd31871ea14", 0x0633f7270c5b1c37}, {"056faa2e15b37549aa8d92972ddf7d34", 0x178afa932c9717cb},
    {"95313903c418f12b4c1a34506d7329d2", 0xb173c276e4f45284}, {"25eb8c48ff89cb854fc09081cc47edfc", 0xa89201f63643c637},
    {"19c7f35c4abe2ea0d897b741714d0380", 0x40b5a9dc5e0ed4f2},
};

std::uint64_t fnv_1a(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 0; i < count; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
  return hash;
}

TEST(UastcBlock, EveryModeAsTheTranscoderDecodesIt) {
  for (const UastcCase& one : kBlocks) {
    std::array<std::uint8_t, 64> texels{};
    ASSERT_TRUE(decode_uastc_block(from_hex(one.block).data(), texels.data())) << one.block;
    EXPECT_EQ(fnv_1a(texels.data(), texels.size()), one.texels) << one.block;
  }
  std::array<std::uint8_t, 64> texels{};
  std::array<std::uint8_t, 16> block{};
  block[0] = 0x45;  // reserved
  EXPECT_FALSE(decode_uastc_block(block.data(), texels.data()));
  block[0] = 0x13;  // mode 4: partition number 31, but there are 30
  block[2] = 0x3f << 4 & 0xff;
  block[3] = 0x0f;
  EXPECT_FALSE(decode_uastc_block(block.data(), texels.data()));
}

// Little-endian words.
std::string little_endian_words(const std::vector<std::uint64_t>& values, std::size_t bytes) {
  std::string text;
  for (const std::uint64_t value : values)
    for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 255);
  return text;
}

struct Ktx2Parts {
  std::uint64_t vk_format = 37, width = 5, height = 3, layers = 0, faces = 1, scheme = 0, model = 1, transfer = 1;
  std::string level;
};

std::string ktx2_of(const Ktx2Parts& k) {
  const std::uint64_t descriptor_at = 104, level_at = 144;
  const std::string stored = [&] {
    if (k.scheme != 2) return k.level;
    std::string packed(ZSTD_compressBound(k.level.size()), ' ');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), k.level.data(), k.level.size(), 3));
    return packed;
  }();
  std::string file("\xabKTX 20\xbb\r\n\x1a\n", 12);
  file += little_endian_words(
      {k.vk_format, 1, k.width, k.height, 0, k.layers, k.faces, 1, k.scheme, descriptor_at, 40, 0, 0}, 4);
  file += little_endian_words({0, 0, level_at, stored.size(), k.level.size()}, 8);
  file += little_endian_words({40, 0, 2 + (36u << 16), k.model + (1u << 8) + (k.transfer << 16)}, 4);
  file.resize(level_at, '\0');
  return file + stored;
}

class Ktx2ImageTest : public ::testing::Test {
 protected:
  std::unique_ptr<LibraryImageFile> open(const Ktx2Parts& parts) const {
    write_bytes(path_, ktx2_of(parts));
    return open_small_library_image(path_, {});
  }
  std::vector<std::uint8_t> rows(LibraryImageFile& file, int begin, int end, int channel_begin, int channel_end) const {
    const PixelBlock block = {0, begin, end, channel_begin, channel_end, number_type::kUint8};
    std::vector<std::uint8_t> bytes(block_bytes(file.part(0), block), 0xA5);
    EXPECT_EQ(file.read_into(block, reinterpret_cast<std::byte*>(bytes.data())), "");
    return bytes;
  }
  void expect_refusal(const Ktx2Parts& parts, const std::vector<std::string>& says) const {
    write_bytes(path_, ktx2_of(parts));
    expect_error(ErrorCode::kInput, says, [&] {
      const auto file = open_small_library_image(path_, {});
      rows(*file, 0, 3, 0, 4);
    });
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "a.png";  // the file is recognised by its content and not by its name
};

TEST_F(Ktx2ImageTest, TexelsAsTheyAre) {
  Ktx2Parts parts;
  for (int i = 0; i < 60; ++i) parts.level += static_cast<char>(4 * i);
  for (const std::uint64_t scheme : {0u, 2u}) {
    parts.scheme = scheme;
    const auto file = open(parts);
    EXPECT_EQ(file->description().format, "ktx2");
    EXPECT_EQ(file->part(0).width, 5);
    EXPECT_EQ(file->part(0).height, 3);
    EXPECT_EQ(file->part(0).channel_names, (std::vector<std::string>{"R", "G", "B", "A"}));
    EXPECT_EQ(file->part(0).colour_space, "");
    const std::vector<std::uint8_t> two = rows(*file, 1, 3, 1, 3);
    ASSERT_EQ(two.size(), 20u);
    for (std::size_t i = 0; i < two.size(); ++i) EXPECT_EQ(two[i], 4 * (20 + 4 * (i / 2) + 1 + i % 2) % 256);
  }
  parts.transfer = 2;
  EXPECT_EQ(open(parts)->part(0).colour_space, "sRGB");
}

TEST_F(Ktx2ImageTest, UastcBlocks) {
  Ktx2Parts parts;
  parts.vk_format = 0;
  parts.model = 166;
  std::vector<std::vector<std::uint8_t>> blocks = {from_hex(kBlocks[0].block), from_hex(kBlocks[3].block)};
  for (const auto& block : blocks) parts.level.append(block.begin(), block.end());
  for (const std::uint64_t scheme : {0u, 2u}) {
    parts.scheme = scheme;
    const auto file = open(parts);
    const std::vector<std::uint8_t> all = rows(*file, 0, 3, 0, 4);
    for (std::size_t y = 0; y < 3; ++y)
      for (std::size_t x = 0; x < 5; ++x) {
        std::array<std::uint8_t, 64> texels{};
        decode_uastc_block(blocks[x / 4].data(), texels.data());
        EXPECT_EQ(std::memcmp(&all[4 * (5 * y + x)], &texels[4 * (4 * y + x % 4)], 4), 0) << x << " " << y;
      }
    EXPECT_EQ(rows(*file, 2, 3, 2, 3)[4], all[4 * 14 + 2]);
  }
}

TEST_F(Ktx2ImageTest, Refusals) {
  Ktx2Parts good;
  good.level.assign(60, 'x');
  const auto expect_changed = [&](const std::function<void(Ktx2Parts&)>& change, const std::vector<std::string>& says) {
    Ktx2Parts parts = good;
    change(parts);
    expect_refusal(parts, says);
  };
  expect_changed([](Ktx2Parts& k) { k.vk_format = 141; }, {"VkFormat 141", "UASTC", "--texels rgba8"});
  expect_changed([](Ktx2Parts& k) { k.layers = 8; }, {"8 layers", "a single picture"});
  expect_changed([](Ktx2Parts& k) { k.faces = 6; }, {"6 faces"});
  expect_changed([](Ktx2Parts& k) { k.scheme = 1; }, {"supercompression 1", "Zstandard"});
  expect_changed([](Ktx2Parts& k) { k.width = 6; }, {"60 bytes", "expected 72"});
  expect_changed([](Ktx2Parts& k) { k.width = 0; }, {"0 x 3"});
  expect_changed([](Ktx2Parts& k) { k.level.resize(59), k.scheme = 2; }, {"59 bytes", "expected 60"});
  expect_changed(
      [](Ktx2Parts& k) {
        k.vk_format = 0, k.model = 166;
        k.level.assign(32, 'E');  // 0x45, reserved
      },
      {"block (0, 0)", "not a UASTC block"});
  write_bytes(path_, ktx2_of(good).substr(0, 150));
  expect_error(ErrorCode::kInput, {path_, "cut"}, [&] { open_small_library_image(path_, {}); });
}

// Tests a texture as multum gltf --format rgba8 writes it, and one inside KHR_texture_basisu.
TEST_F(Ktx2ImageTest, MaterialsOfModels) {
  Ktx2Parts parts;
  parts.level.assign(60, 'x');
  write_bytes(folder_ / "n.ktx2", ktx2_of(parts));
  const auto model = [&](const std::string& texture) {
    write_bytes(folder_ / "m.gltf", R"({"asset":{"version":"2.0"},"images":[{"uri":"n.ktx2"}],"textures":[)" + texture +
                                        R"(],"materials":[{"normalTexture":{"index":0}}]})");
    return read_gltf_materials(folder_ / "m.gltf");
  };
  for (const char* texture : {R"({"source":0})", R"({"extensions":{"KHR_texture_basisu":{"source":0}}})"}) {
    const GltfMaterials found = model(texture);
    ASSERT_EQ(found.images.size(), 1u);
    EXPECT_EQ(found.materials[0].normal->image, 0);
    EXPECT_EQ(open_small_library_image(extract_image(found.images[0], folder_.path()), {})->part(0).width, 5);
  }
}

}  // namespace
}  // namespace multum::testing
