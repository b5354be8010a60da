// SPDX-License-Identifier: Apache-2.0
// Tests channels of EXR files of several parts, and compares Cryptomatte coverage with closed forms and real files.
#include "host/formats/image/files/exr_layers.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "host/formats/image/image_reader.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

using Plane = std::vector<float>;

float identifier(std::uint32_t bits) { return std::bit_cast<float>(bits); }

void expect_refused(const std::vector<std::string>& parts, const std::function<void()>& body) {
  expect_error(ErrorCode::kInput, parts, body);
}

TEST(ExrLayers, ChannelsOfAnyPartAreReadRowZeroAtTheTop) {
  const TemporaryFolder folder;
  const std::string file = folder / "parts.exr";
  write_exr(file, 2, 2,
            {{"colour", {"R", "G", "B"}, {Plane{1, 2, 3, 4}, Plane{5, 6, 7, 8}, Plane{9, 10, 11, 12}}, {}},
             {"more", {"diffuse.R", "Z"}, {Plane{13, 14, 15, 16}, Plane{0.1f, NAN, HUGE_VALF, -2.0f}}, {}}});
  const ExrLayers layers = read_exr_channels(file, {"Z", "G", "diffuse.R"});
  EXPECT_EQ(layers.width, 2);
  EXPECT_EQ(layers.height, 2);
  EXPECT_EQ(layers.channels.size(), 3u);
  EXPECT_EQ(layers.channels.at("G"), (Plane{5, 6, 7, 8}));
  EXPECT_EQ(layers.channels.at("diffuse.R"), (Plane{13, 14, 15, 16}));
  EXPECT_EQ(layers.channels.at("Z")[0], 0.1f);
  EXPECT_TRUE(std::isnan(layers.channels.at("Z")[1]));
  EXPECT_EQ(layers.channels.at("Z")[2], HUGE_VALF);
  std::vector<std::string> names = exr_channel_names(file);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"B", "G", "R", "Z", "diffuse.R"}));
}

// Reading maps limits the number of channels for the whole process. Renders with many passes must still be readable.
TEST(ExrLayers, MoreChannelsThanAMapMayHave) {
  const TemporaryFolder folder;
  write_test_image(folder / "map.png", normal_image(8, 8));
  ImageReader(folder / "map.png", {});
  ExrPart part;
  for (int i = 0; i < 100; ++i) part.channels.push_back("pass" + std::to_string(100 + i) + ".R");
  part.planes.assign(100, Plane{1.0f});
  part.planes[99] = {7.0f};
  write_exr(folder / "many.exr", 1, 1, {part});
  EXPECT_EQ(read_exr_channels(folder / "many.exr", {"pass199.R"}).channels.at("pass199.R"), Plane{7.0f});
}

TEST(ExrLayers, RefusalsNameFileAndChannel) {
  const TemporaryFolder folder;
  const std::string file = folder / "some.exr";
  write_exr(file, 1, 1, {{"", {"Y", "Z"}, {Plane{1}, Plane{2}}, {}}});
  expect_refused({file, "no channel \"X\"", "Y, Z"}, [&] { read_exr_channels(file, {"Z", "X"}); });
  expect_refused({folder / "none.exr", "no such"}, [&] { read_exr_channels(folder / "none.exr", {"Z"}); });
  write_test_image(folder / "map.png", normal_image(8, 8));
  expect_refused({"map.png", "png", "OpenEXR"}, [&] { exr_channel_names(folder / "map.png"); });

  write_exr(folder / "whole.exr", 1, 1, {{"", {"object"}, {Plane{1}}, {}, "uint"}});
  expect_refused({"whole.exr", "\"object\"", "integers", "half", "float"},
                 [&] { read_exr_channels(folder / "whole.exr", {"object"}); });

  const Plane noise = [] {
    Plane values(64 * 64);
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(std::sin(1e3 * static_cast<double>(i)));
    return values;
  }();
  write_exr(folder / "cut.exr", 64, 64, {{"", {"Z"}, {noise}, {}}});
  const std::string bytes = read_bytes(folder / "cut.exr");
  write_bytes(folder / "cut.exr", bytes.substr(0, bytes.size() / 2));
  expect_refused({"cut.exr", "damaged"}, [&] { read_exr_channels(folder / "cut.exr", {"Z"}); });
}

TEST(ExrLayers, CropsAreRefusedInEveryPart) {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec(2, 2, 1, OIIO::TypeDesc::FLOAT);
  spec.channelnames = {"Z"};
  spec.x = 1;
  spec.full_width = spec.full_height = 4;
  const Plane plane(16, 1.0f);
  auto output = OIIO::ImageOutput::create(folder / "crop.exr");
  ASSERT_TRUE(output->open(folder / "crop.exr", spec) && output->write_image(OIIO::TypeDesc::FLOAT, plane.data()));
  ASSERT_TRUE(output->close());
  expect_refused({"crop.exr", "2 x 2 at (1, 0)", "4 x 4", "whole frame"},
                 [&] { read_exr_channels(folder / "crop.exr", {"Z"}); });

  // All parts share a display window, so a part with another size is also a crop.
  OIIO::ImageSpec specs[2] = {{4, 4, 1, OIIO::TypeDesc::FLOAT}, {2, 2, 1, OIIO::TypeDesc::FLOAT}};
  specs[1].full_width = specs[1].full_height = 4;
  specs[0].attribute("oiio:subimagename", "a");
  specs[1].attribute("oiio:subimagename", "b");
  const std::string sizes = folder / "sizes.exr";
  output = OIIO::ImageOutput::create(sizes);
  ASSERT_TRUE(output->open(sizes, 2, specs)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, plane.data())) << output->geterror();
  ASSERT_TRUE(output->open(sizes, specs[1], OIIO::ImageOutput::AppendSubimage)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, plane.data())) << output->geterror();
  ASSERT_TRUE(output->close());
  expect_refused({"sizes.exr", "2 x 2 at (0, 0)", "4 x 4"}, [&] { exr_channel_names(sizes); });
}

// Identifiers follow the public test vectors of MurmurHash3. Some names are from Blender's manifests, with lengths that
// leave tails of 0, 1 and 3 bytes. Other names have hashes with an exponent of all ones or zeros.
const std::uint32_t kWalls = 0x0810d53du, kVase = 0x6aaa21aau, kParfait = 0xb007361bu;

ExrPart cryptomatte_part() {
  ExrPart part;
  for (const char* level : {"CryptoObject00", "CryptoObject01"})
    for (const char* c : {".r", ".g", ".b", ".a"}) part.channels.push_back(std::string(level) + c);
  part.planes.assign(8, Plane(3, 0.0f));
  part.attributes = {{"cryptomatte/0a1b2c3/name", "ViewLayer.CryptoObject"},
                     {"cryptomatte/0a1b2c3/hash", "MurmurHash3_32"},
                     {"cryptomatte/0a1b2c3/conversion", "uint32_to_float32"}};
  return part;
}

void set_rank(ExrPart& part, std::size_t pixel, std::size_t rank, std::uint32_t bits, float coverage) {
  part.planes[2 * rank][pixel] = identifier(bits);
  part.planes[2 * rank + 1][pixel] = coverage;
}

TEST(Cryptomatte, CoverageByManifestAndByHash) {
  const TemporaryFolder folder;
  ExrPart part = cryptomatte_part();
  set_rank(part, 0, 0, kWalls, 0.5f);
  set_rank(part, 0, 1, 0x11223344u, 0.25f);
  set_rank(part, 0, 2, kVase, 0.125f);
  set_rank(part, 0, 3, kParfait, 0.0625f);
  set_rank(part, 1, 0, kVase, 1.0f);
  set_rank(part, 2, 0, kVase, 0.75f);
  set_rank(part, 2, 1, kVase, 0.75f);  // the same object twice; its shares are added, up to 1
  part.attributes.emplace_back("cryptomatte/0a1b2c3/manifest", R"({"walls":"0810d53d","other":"11223344"})");
  write_exr(folder / "crypto.exr", 3, 1, {part});
  const auto coverage = read_cryptomatte_coverage(folder / "crypto.exr", "CryptoObject",
                                                  {"vase", "walls", "other", "parfait", "table_top"});
  EXPECT_EQ(coverage, (std::vector<Plane>{Plane{0.125f, 1.0f, 1.0f},  // by hash
                                          Plane{0.5f, 0.0f, 0.0f},    // identified by the manifest
                                          Plane{0.25f, 0.0f, 0.0f},   // its identifier differs from the name's hash
                                          Plane{0.0625f, 0.0f, 0.0f}, Plane(3, 0.0f)}));
  EXPECT_EQ(find_cryptomatte_names(folder / "crypto.exr", "CryptoObject", {}).manifest,
            (std::vector<std::string>{"other", "walls"}));
  EXPECT_EQ(read_cryptomatte_coverage(folder / "crypto.exr", "ViewLayer.CryptoObject", {"walls"})[0][0], 0.5f)
      << "the metadata's full name finds channels that have a shorter name";
}

TEST(Cryptomatte, HashesThatAreNoFloatsAreChangedAsTheSpecificationSays) {
  const TemporaryFolder folder;
  ExrPart part = cryptomatte_part();
  set_rank(part, 0, 0, 0xffaf2b61u ^ 1u << 23, 0.5f);   // "leaf87", exponent 255
  set_rank(part, 0, 1, 0x805f5b3bu ^ 1u << 23, 0.25f);  // "leaf177", exponent 0
  write_exr(folder / "crypto.exr", 3, 1, {part});
  const auto coverage = read_cryptomatte_coverage(folder / "crypto.exr", "CryptoObject", {"leaf87", "leaf177"});
  EXPECT_EQ(coverage[0][0], 0.5f);
  EXPECT_EQ(coverage[1][0], 0.25f);
  EXPECT_TRUE(find_cryptomatte_names(folder / "crypto.exr", "CryptoObject", {}).manifest.empty());
}

TEST(Cryptomatte, CoverageThatIsNoShareCountsAsNone) {
  const TemporaryFolder folder;
  ExrPart part = cryptomatte_part();
  set_rank(part, 0, 0, kWalls, NAN);
  set_rank(part, 1, 0, kWalls, HUGE_VALF);
  set_rank(part, 2, 0, kWalls, -0.5f);
  set_rank(part, 2, 1, kWalls, 0.25f);
  write_exr(folder / "crypto.exr", 3, 1, {part});
  EXPECT_EQ(read_cryptomatte_coverage(folder / "crypto.exr", "CryptoObject", {"walls"})[0], (Plane{0.0f, 0.0f, 0.25f}));
}

TEST(Cryptomatte, Refusals) {
  const TemporaryFolder folder;
  const std::string file = folder / "crypto.exr";
  const auto expect_part_refused = [&](const ExrPart& part, const std::vector<std::string>& parts) {
    write_exr(file, 3, 1, {part});
    std::vector<std::string> all = parts;
    all.push_back(file);
    expect_refused(all, [&] { read_cryptomatte_coverage(file, "CryptoObject", {"walls"}); });
  };
  ExrPart part = cryptomatte_part();
  part.attributes.emplace_back("cryptomatte/1111111/name", "Other.CryptoObject");
  expect_part_refused(part, {"several Cryptomattes", "ViewLayer.CryptoObject, Other.CryptoObject"});
  part = cryptomatte_part();
  part.attributes[1].second = "CRC32";
  expect_part_refused(part, {"manifest", "no \"walls\"", "\"CRC32\""});
  part = cryptomatte_part();
  part.attributes[2].second = "none";
  expect_part_refused(part, {"\"none\"", "uint32_to_float32"});
  part = cryptomatte_part();
  part.channels[0] = "Other00.r";
  expect_part_refused(part, {"no channel \"CryptoObject00.r\""});
  part = cryptomatte_part();
  part.channels[3] = "Other00.a";
  expect_part_refused(part, {"no channel \"CryptoObject00.a\""});
  part = cryptomatte_part();
  part.type = "half";
  expect_part_refused(part, {"half", "Cryptomatte"});
}

// Makes files as other renderers and repacking programs write them. Half of pixel 0 is "vase", which no manifest names,
// and a quarter is "walls".
class ForeignCryptomatte : public ::testing::Test {
 protected:
  ForeignCryptomatte() {
    set_rank(part_, 0, 0, kVase, 0.5f);
    set_rank(part_, 0, 1, kWalls, 0.25f);
  }

  void rename(const std::string& layer, const std::vector<std::string>& suffixes) {
    for (std::size_t i = 0; i < 8; ++i) part_.channels[i] = layer + (i < 4 ? "00." : "01.") + suffixes[i % 4];
  }

  // Returns the warnings.
  std::vector<std::string> expect_read(const std::string& layer) {
    const std::string file = folder_ / "crypto.exr";
    write_exr(file, 3, 1, {part_});
    const auto coverage = read_cryptomatte_coverage(file, layer, {"vase", "walls"});
    EXPECT_EQ(coverage[0], (Plane{0.5f, 0.0f, 0.0f}));
    EXPECT_EQ(coverage[1], (Plane{0.25f, 0.0f, 0.0f}));
    const CryptomatteNames names = find_cryptomatte_names(file, layer, {"vase", "walls", "nobody"});
    EXPECT_EQ(names.unseen, std::vector<std::string>{"nobody"});
    return names.warnings;
  }

  const TemporaryFolder folder_;
  ExrPart part_ = cryptomatte_part();
};

TEST_F(ForeignCryptomatte, SuffixesOfOtherPrograms) {
  const std::vector<std::vector<std::string>> all = {
      {"R", "G", "B", "A"}, {"red", "green", "blue", "alpha"}, {"Red", "Green", "Blue", "Alpha"}};
  for (const auto& suffixes : all) {
    rename("CryptoObject", suffixes);
    EXPECT_TRUE(expect_read("CryptoObject").empty());
  }
}

TEST_F(ForeignCryptomatte, ViewLayersBeforeEitherName) {
  for (const char* channels : {"CryptoObject", "View Layer.CryptoObject", "left.ViewLayer.CryptoObject"})
    for (const char* stated : {"CryptoObject", "ViewLayer.CryptoObject"})
      for (const char* asked : {"CryptoObject", "ViewLayer.CryptoObject"}) {
        SCOPED_TRACE(std::string(channels) + " " + stated + " " + asked);
        rename(channels, {"r", "g", "b", "a"});
        part_.name = "crypto";  // channel names do not contain this part name
        part_.attributes[0].second = stated;
        EXPECT_TRUE(expect_read(asked).empty());
      }
}

TEST_F(ForeignCryptomatte, PartsThatHaveTheNameOfTheLayer) {
  ExrPart first{"CryptoObject00", {"R", "G", "B", "A"}, {}, part_.attributes}, second = first;
  second.name = "CryptoObject01";
  first.planes.assign(part_.planes.begin(), part_.planes.begin() + 4);
  second.planes.assign(part_.planes.begin() + 4, part_.planes.end());
  const std::string file = folder_ / "parts.exr";
  write_exr(file, 3, 1, {first, second});
  const auto coverage = read_cryptomatte_coverage(file, "CryptoObject", {"vase", "walls"});
  EXPECT_EQ(coverage[0], (Plane{0.5f, 0.0f, 0.0f}));
  EXPECT_EQ(coverage[1], (Plane{0.25f, 0.0f, 0.0f}));
}

TEST_F(ForeignCryptomatte, NamesThatTheManifestLacks) {
  part_.attributes.emplace_back("cryptomatte/0a1b2c3/manifest", R"({"walls":"0810d53d","other":"11223344"})");
  const std::vector<std::string> warnings = expect_read("CryptoObject");
  ASSERT_EQ(warnings.size(), 1u);
  expect_says(warnings[0], {"manifest", "no \"vase\"", "hash"});
}

TEST_F(ForeignCryptomatte, DamagedManifests) {
  part_.attributes.emplace_back("cryptomatte/0a1b2c3/manifest", "");
  for (const char* manifest :
       {"{\"walls\":", R"({"walls":"no"})", R"({"walls":17})", R"({"walls":""})", R"({"walls":"123456789"})",
        R"(["walls"])", R"({"other":"11223344","wal)", "{\"a\":{\"b\":"}) {
    SCOPED_TRACE(manifest);
    part_.attributes.back().second = manifest;
    const std::vector<std::string> warnings = expect_read("CryptoObject");
    ASSERT_FALSE(warnings.empty());
    expect_says(warnings[0], {"manifest", "damaged", "hash"});
  }
  // The entries of the manifest before the damaged one are still used.
  set_rank(part_, 0, 2, 0x11223344u, 0.125f);
  part_.attributes.back().second = R"({"other":"11223344","wal)";
  write_exr(folder_ / "cut.exr", 3, 1, {part_});
  EXPECT_EQ(read_cryptomatte_coverage(folder_ / "cut.exr", "CryptoObject", {"other"})[0][0], 0.125f);
}

TEST_F(ForeignCryptomatte, MetadataWithoutANameAreMatchedByTheirKey) {
  part_.attributes = {{"cryptomatte/7f2a5c1/hash", "MurmurHash3_32"},
                      {"cryptomatte/7f2a5c1/manifest", R"({"walls":"0810d53d"})"}};
  std::vector<std::string> warnings = expect_read("CryptoObject");  // the key of another layer
  ASSERT_EQ(warnings.size(), 1u);
  expect_says(warnings[0], {"no metadata", "\"CryptoObject\"", "MurmurHash3"});
  // The key has the first digits of the hash of "CryptoObject". The manifest's identifier is not the hash of its name.
  part_.attributes = {{"cryptomatte/3ae39a5/manifest", R"({"other":"11223344"})"}};
  set_rank(part_, 0, 2, 0x11223344u, 0.125f);
  warnings = expect_read("CryptoObject");
  ASSERT_EQ(warnings.size(), 3u);
  expect_says(warnings[0], {"do not contain its name", "\"CryptoObject\"", "hash"});
  EXPECT_EQ(read_cryptomatte_coverage(folder_ / "crypto.exr", "CryptoObject", {"other"})[0][0], 0.125f);
  part_.attributes.clear();
  EXPECT_EQ(expect_read("CryptoObject").size(), 1u);
}

// The rooms of the real field hold only its objects, so their coverages sum to 1, by manifest and by hash.
TEST(Cryptomatte, RealCoveragesSumToOne) {
  if (shared_field().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder with field_demo1";
  const std::string file = shared_field() + "/geom_v03.exr";
  const std::vector<std::string> names = find_cryptomatte_names(file, "CryptoObject", {}).manifest;
  EXPECT_EQ(names, (std::vector<std::string>{"floor", "parfait", "stand", "table_top", "vase", "walls"}));
  const auto coverages = read_cryptomatte_coverage(file, "CryptoObject", names);
  const std::vector<float> largest = read_exr_channels(file, {"id.I"}).channels.at("id.I");
  const std::vector<std::string> by_number = {"walls", "floor", "stand", "table_top", "vase", "parfait"};
  for (std::size_t i = 0; i < largest.size(); ++i) {
    float sum = 0.0f;
    std::size_t best = 0;
    for (std::size_t k = 0; k < names.size(); ++k) {
      sum += coverages[k][i];
      if (coverages[k][i] > coverages[best][i]) best = k;
    }
    ASSERT_NEAR(sum, 1.0f, 1e-3f) << i;
    if (coverages[best][i] > 0.6f) {
      ASSERT_EQ(names[best], by_number[static_cast<std::size_t>(largest[i]) - 1]) << i;
    }
  }
}

}  // namespace
}  // namespace multum::testing
