// SPDX-License-Identifier: Apache-2.0
// Tests reading normal maps. Every encoding gives the original normals again, even if the encoding must be detected.
// Other files are refused, every repair is counted, and the number of threads does not change a single bit.
#include "host/formats/image/normals/normal_map.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include <glm/geometric.hpp>

#include "host/formats/image/normals/encoding_detection.h"
#include "host/formats/image/normals/normal_decode.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

std::string warnings(const NormalMap& map) {
  std::string text;
  for (const std::string& warning : map.report.warnings) text += warning + "\n";
  return text;
}

std::int64_t repair_count(const NormalMap& map) {
  return map.report.nonfinite_repaired + map.report.zero_length_repaired + map.report.below_horizon_repaired;
}

void expect_unit_above_horizon(const NormalMap& map) {
  for (std::size_t i = 0; i < map.x.size(); ++i) {
    const double x = static_cast<double>(map.x[i]), y = static_cast<double>(map.y[i]),
                 z = static_cast<double>(map.z[i]);
    ASSERT_NEAR(std::sqrt(x * x + y * y + z * z), 1.0, 2e-7) << "texel " << i;
    ASSERT_GE(z, kHorizonZ * (1.0 - 1e-6)) << "texel " << i;
  }
}

struct EncodingCase {
  const char* file;
  TypeDesc::BASETYPE type;
  bool is_signed;
  double green_sign;
  double tolerance;  // for unit vectors: the quantum, or the error of the compression
};

class NormalEncoding : public ::testing::TestWithParam<EncodingCase> {};

TEST_P(NormalEncoding, IsFoundAndDecoded) {
  const EncodingCase& test = GetParam();
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{96, 80}, {61, 47}}) {
    TestImage image = normal_image(width, height, test.is_signed, test.green_sign);
    image.type = test.type;
    write_test_image(folder / test.file, image);
    const NormalMap map = read_map(folder / test.file);
    EXPECT_LT(largest_difference(map, surface_normals(width, height)), test.tolerance) << map.report.encoding_reason;
    EXPECT_TRUE(contains(map.report.encoding, test.is_signed ? ", signed" : ", unsigned")) << map.report.encoding;
    EXPECT_TRUE(contains(map.report.encoding, test.green_sign > 0 ? "green up" : "green down")) << map.report.encoding;
    EXPECT_FALSE(contains(map.report.encoding, "undecided")) << map.report.encoding_reason;
    EXPECT_EQ(repair_count(map), 0);
    expect_unit_above_horizon(map);
  }
}

INSTANTIATE_TEST_SUITE_P(All, NormalEncoding,
                         ::testing::Values(EncodingCase{"a.png", TypeDesc::UINT8, false, 1, 0.012},
                                           EncodingCase{"a.png", TypeDesc::UINT8, false, -1, 0.012},
                                           EncodingCase{"a.png", TypeDesc::UINT16, false, 1, 4e-5},
                                           EncodingCase{"a.png", TypeDesc::UINT16, false, -1, 4e-5},
                                           EncodingCase{"a.tif", TypeDesc::UINT16, false, -1, 4e-5},
                                           EncodingCase{"a.tif", TypeDesc::FLOAT, true, 1, 1e-6},
                                           EncodingCase{"a.exr", TypeDesc::HALF, true, 1, 1e-3},
                                           EncodingCase{"a.exr", TypeDesc::HALF, true, -1, 1e-3},
                                           EncodingCase{"a.exr", TypeDesc::HALF, false, 1, 2e-3},
                                           EncodingCase{"a.exr", TypeDesc::FLOAT, false, -1, 1e-6},
                                           EncodingCase{"a.exr", TypeDesc::FLOAT, true, 1, 1e-6},
                                           EncodingCase{"a.jpg", TypeDesc::UINT8, false, 1, 0.4},
                                           EncodingCase{"a.webp", TypeDesc::UINT8, false, -1, 0.4}));

TEST(NormalMapReading, TwoChannelsRebuildZ) {
  const TemporaryFolder folder;
  for (const float blue : {0.0f, 0.5f, 1.0f}) {
    TestImage image = normal_image(64, 48);
    image.type = TypeDesc::UINT16;
    for (std::size_t i = 2; i < image.values.size(); i += 3) image.values[i] = blue;
    write_test_image(folder / "a.png", image);
    const NormalMap map = read_map(folder / "a.png");
    EXPECT_TRUE(contains(map.report.encoding, "two channels")) << blue << ": " << map.report.encoding;
    EXPECT_LT(largest_difference(map, surface_normals(64, 48)), 1e-4) << blue;
  }
  for (const bool is_signed : {false, true}) {
    const TestImage full = normal_image(64, 48, is_signed);
    TestImage image = full;
    image.channels = 2;
    image.channel_names = {"R", "G"};
    image.type = TypeDesc::FLOAT;
    image.values.clear();
    for (std::size_t i = 0; i < full.values.size(); ++i)
      if (i % 3 != 2) image.values.push_back(full.values[i]);
    write_test_image(folder / "a.exr", image);
    const NormalMap map = read_map(folder / "a.exr");
    EXPECT_TRUE(contains(map.report.encoding, is_signed ? ", signed" : ", unsigned")) << map.report.encoding;
    EXPECT_LT(largest_difference(map, surface_normals(64, 48)), 1e-5);
  }
}

// A constant blue is a placeholder and not z, even if some vectors happen to have unit length. As z, a blue of 0 would
// point down, and a blue of 1 is near the z of most texels. Covers steepness up to 62 degrees, compression noise on
// blue, 8 and 16 bits, and floats.
TEST(NormalMapReading, AConstantBlueIsFillerWhereItCompletesNoVector) {
  const TemporaryFolder folder;
  for (const double steepness : {0.15, 0.3, 0.6}) {
    const std::vector<glm::dvec3> normals = surface_normals(96, 80, steepness);
    for (const auto& [name, type, tolerance] : {std::tuple{"a.png", TypeDesc::UINT8, 0.02},
                                                {"a.png", TypeDesc::UINT16, 1e-4},
                                                {"a.exr", TypeDesc::FLOAT, 1e-5}}) {
      for (const float blue : {0.0f, 0.5f, 1.0f}) {
        for (const int noise : {0, 1}) {
          TestImage image{.width = 96, .height = 80, .type = type};
          for (std::size_t i = 0; i < normals.size(); ++i) {
            image.values.push_back(static_cast<float>(normals[i].x * 0.5 + 0.5));
            image.values.push_back(static_cast<float>(normals[i].y * 0.5 + 0.5));
            image.values.push_back(std::abs(blue - static_cast<float>(noise) * static_cast<float>(i % 3) / 255.0f));
          }
          write_test_image(folder / name, image);
          SCOPED_TRACE(::testing::Message() << name << " steepness " << steepness << " blue " << blue << ' ' << noise);
          const NormalMap map = read_map(folder / name);
          EXPECT_LT(largest_difference(map, normals), tolerance) << map.report.encoding_reason;
          EXPECT_TRUE(contains(map.report.encoding, "two channels")) << map.report.encoding_reason;
          EXPECT_TRUE(contains(map.report.encoding_reason, "blue is")) << map.report.encoding_reason;
        }
      }
    }
  }
}

// The z of nearly flat normals rounds to a single code. This blue is still read as z. A z that is computed from x and y
// would differ by at most half a code.
TEST(NormalMapReading, TheBlueOfNearlyFlatMapsStaysZ) {
  const TemporaryFolder folder;
  for (const double steepness : {0.01, 0.03}) {
    TestImage image{.width = 96, .height = 80};
    for (const glm::dvec3& n : surface_normals(96, 80, steepness))
      for (const double v : {n.x, n.y, n.z}) image.values.push_back(static_cast<float>(v * 0.5 + 0.5));
    write_test_image(folder / "a.png", image);
    const NormalMap map = read_map(folder / "a.png");
    EXPECT_FALSE(contains(map.report.encoding, "two channels")) << map.report.encoding_reason;
    NormalMapSettings settings;
    settings.two_channel = true;
    settings.green = GreenAxis::kUp;
    const NormalMap rebuilt = read_map(folder / "a.png", settings);
    for (std::size_t i = 0; i < map.x.size(); ++i) {
      ASSERT_NEAR(map.x[i], rebuilt.x[i], 0.5 / 127.5);
      ASSERT_NEAR(map.y[i], rebuilt.y[i], 0.5 / 127.5);
    }
  }
}

// Normals that were multiplied by a constant are normalised again, and a warning says so. If they are so short that
// rounding in the file destroys them, the map is refused, and the message gives their length.
TEST(NormalMapReading, ScaledVectorsAreNormalisedAndSaid) {
  const TemporaryFolder folder;
  struct Case {
    const char* file;
    TypeDesc::BASETYPE type;
    bool is_signed;
    double scale, tolerance;
  };
  for (const Case& test : {Case{"a.exr", TypeDesc::FLOAT, true, 0.01, 1e-5},
                           {"a.exr", TypeDesc::HALF, true, 0.01, 1e-3},
                           {"a.exr", TypeDesc::FLOAT, true, 1e-4, 1e-5},
                           {"a.exr", TypeDesc::FLOAT, true, 100.0, 1e-5},
                           {"a.exr", TypeDesc::FLOAT, false, 0.01, 1e-4},
                           {"a.png", TypeDesc::UINT16, false, 0.01, 5e-3},
                           {"a.png", TypeDesc::UINT16, false, 0.3, 2e-4}}) {
    SCOPED_TRACE(::testing::Message() << test.file << " times " << test.scale);
    TestImage image{.width = 96, .height = 80, .type = test.type};
    for (const glm::dvec3& n : surface_normals(96, 80))
      for (const double v : {n.x, n.y, n.z})
        image.values.push_back(static_cast<float>(test.is_signed ? v * test.scale : v * test.scale * 0.5 + 0.5));
    write_test_image(folder / test.file, image);
    const NormalMap map = read_map(folder / test.file);
    EXPECT_LT(largest_difference(map, surface_normals(96, 80)), test.tolerance) << map.report.encoding_reason;
    expect_says(warnings(map), {"instead of 1", "scaled normals"});
  }
  TestImage image{.width = 96, .height = 80};
  for (const glm::dvec3& n : surface_normals(96, 80))
    for (const double v : {n.x, n.y, n.z}) image.values.push_back(static_cast<float>(v * 0.01 * 0.5 + 0.5));
  write_test_image(folder / "a.png", image);
  expect_error(ErrorCode::kInput, {"a.png", "--bumpformat"}, [&] { read_map(folder / "a.png"); });
}

// Two outliers do not change whether a map is recognised as grey or which direction of green is found. Outliers are
// repaired like NaN.
TEST(NormalMapReading, OutliersHideNothing) {
  const TemporaryFolder folder;
  for (const float outlier : {1e12f, 1e30f, -1e30f}) {
    TestImage image = normal_image(96, 80, true);
    image.type = TypeDesc::FLOAT;
    for (const auto& [column, row] : {std::pair{10, 10}, {50, 40}})
      for (int c = 0; c < 3; ++c) image.at(column, row, c) = outlier;
    write_test_image(folder / "a.exr", image);
    const NormalMap map = read_map(folder / "a.exr");
    EXPECT_TRUE(contains(map.report.encoding, "normal map, signed")) << map.report.encoding;
    EXPECT_EQ(map.report.nonfinite_repaired, 2);
    EXPECT_LT(largest_difference(map, surface_normals(96, 80)), 0.1) << "neighbours fill them";
  }
}

// (x, y, 1) without normalisation: blue is constant but meaningful, since x^2 + y^2 exceeds 1.
TEST(NormalMapReading, ConstantBlueOfSteepSlopesIsUsed) {
  const TemporaryFolder folder;
  TestImage image;
  image.width = image.height = 64;
  image.type = TypeDesc::UINT16;
  std::vector<glm::dvec3> normals = surface_normals(64, 64, 0.9);
  for (glm::dvec3& n : normals) {
    n = glm::dvec3(std::clamp(n.x / n.z, -1.0, 1.0), std::clamp(n.y / n.z, -1.0, 1.0), 1.0);  // clamped
    for (const double v : {n.x, n.y, n.z}) image.values.push_back(static_cast<float>(v * 0.5 + 0.5));
    n /= std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  }
  write_test_image(folder / "a.png", image);
  const NormalMap map = read_map(folder / "a.png");
  EXPECT_FALSE(contains(map.report.encoding, "two channels")) << map.report.encoding_reason;
  EXPECT_LT(largest_difference(map, normals), 1e-4);
}

TEST(NormalMapReading, AlphaHoldsAHeightAndIsLeftAlone) {
  const TemporaryFolder folder;
  const TestImage full = normal_image(64, 64);
  TestImage image = full;
  image.channels = 4;
  image.alpha_channel = 3;
  image.values.clear();
  for (std::size_t i = 0; i < full.values.size(); i += 3) {
    image.values.insert(image.values.end(), {full.values[i], full.values[i + 1], full.values[i + 2]});
    image.values.push_back(static_cast<float>(i % 97) / 97.0f);
  }
  write_test_image(folder / "a.png", image);
  EXPECT_LT(largest_difference(read_map(folder / "a.png"), surface_normals(64, 64)), 0.012);
}

TEST(NormalMapReading, OverridesWin) {
  const TemporaryFolder folder;
  TestImage image = normal_image(64, 64);
  image.type = TypeDesc::UINT16;
  write_test_image(folder / "a.png", image);
  const NormalMap found = read_map(folder / "a.png");
  NormalMapSettings settings;
  settings.green = GreenAxis::kDown;
  const NormalMap flipped = read_map(folder / "a.png", settings);
  EXPECT_TRUE(contains(flipped.report.encoding, "green down (DirectX), as requested"));
  for (std::size_t i = 0; i < found.y.size(); ++i) ASSERT_EQ(flipped.y[i], -found.y[i]);
  settings = {};
  settings.two_channel = true;
  EXPECT_TRUE(contains(read_map(folder / "a.png", settings).report.encoding, "two channels"));
  settings = {};
  settings.is_signed = true;
  settings.bump_format = BumpFormat::kNormal;
  EXPECT_TRUE(contains(read_map(folder / "a.png", settings).report.encoding, ", signed"));
  settings = {};
  settings.bump_format = BumpFormat::kHeight;
  expect_error(ErrorCode::kInput, {"a.png", "found colours", "expected heights"},
               [&] { read_map(folder / "a.png", settings); });
}

TEST(NormalMapReading, FlatMapsAreExactlyFlat) {
  const TemporaryFolder folder;
  for (const auto& [r, g] : {std::pair{127, 127}, {128, 128}, {127, 128}}) {
    for (const int size : {1, 2, 16}) {
      TestImage image;
      image.width = size;
      image.height = 1 + size / 2;
      for (int i = 0; i < image.width * image.height; ++i)
        for (const int v : {r, g, 255}) image.values.push_back(static_cast<float>(v) / 255.0f);
      write_test_image(folder / "flat.png", image);
      const NormalMap map = read_map(folder / "flat.png");
      EXPECT_TRUE(contains(map.report.encoding, "undecided")) << map.report.encoding;
      EXPECT_TRUE(contains(warnings(map), "bring no benefit")) << warnings(map);
      EXPECT_FALSE(contains(warnings(map), "green")) << warnings(map);  // 0 means both signs of green
      for (std::size_t i = 0; i < map.x.size(); ++i) {
        EXPECT_EQ(map.x[i], 0.0f);
        EXPECT_EQ(map.y[i], 0.0f);
        EXPECT_EQ(map.z[i], 1.0f);
      }
    }
  }
}

// If directions change randomly from texel to texel, they are not the slopes of a surface, whether green is up or down.
TEST(NormalMapReading, UndecidedGreenIsWarnedOf) {
  const TemporaryFolder folder;
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  TestImage image{.width = 64, .height = 64};
  for (int i = 0; i < 64 * 64; ++i) {
    const double x = uniform(generator), y = uniform(generator);
    for (const double v : {x, y, std::sqrt(1.0 - x * x - y * y)})
      image.values.push_back(static_cast<float>(v * 0.5 + 0.5));
  }
  write_test_image(folder / "facets.png", image);
  const NormalMap map = read_map(folder / "facets.png");
  EXPECT_TRUE(contains(map.report.encoding, "green up (OpenGL), undecided")) << map.report.encoding_reason;
  expect_says(warnings(map), {"up (OpenGL)", "--green up", "--green down"});
  NormalMapSettings settings;
  settings.green = GreenAxis::kDown;
  EXPECT_EQ(warnings(read_map(folder / "facets.png", settings)), "");
}

// If a setting contradicts the gradients, the program follows the setting and prints a warning. If the setting agrees
// with the gradients or nothing contradicts it, there is no warning.
TEST(NormalMapReading, GreenAgainstTheGradientsIsWarnedOf) {
  const TemporaryFolder folder;
  for (const double file_sign : {1.0, -1.0}) {
    TestImage image = normal_image(96, 80, false, file_sign);
    write_test_image(folder / "a.png", image);
    for (const GreenAxis asked : {GreenAxis::kUp, GreenAxis::kDown}) {
      NormalMapSettings settings;
      settings.green = asked;
      const NormalMap map = read_map(folder / "a.png", settings);
      EXPECT_TRUE(contains(map.report.encoding, asked == GreenAxis::kUp ? "green up" : "green down"));
      const bool agrees = (asked == GreenAxis::kUp) == (file_sign > 0.0);
      if (agrees) EXPECT_EQ(warnings(map), "");
      else
        expect_says(warnings(map), {"gradient agreement", asked == GreenAxis::kUp ? "--green down" : "--green up",
                                    "green was set to"});
    }
  }
}

TEST(NormalMapReading, FlatTwoChannelFloatsAreSigned) {
  const TemporaryFolder folder;
  TestImage image{
      .width = 4, .height = 4, .channels = 2, .values = std::vector<float>(32, 0.0f), .type = TypeDesc::HALF};
  image.channel_names = {"R", "G"};
  write_test_image(folder / "flat.exr", image);
  const NormalMap map = read_map(folder / "flat.exr");
  EXPECT_TRUE(contains(map.report.encoding, ", signed")) << map.report.encoding;
  EXPECT_EQ(map.z[5], 1.0f);
}

TEST(NormalMapReading, EightBitsDecodeAsAGpuDoes) {
  const glm::dvec3 v = decode_vector({.flat_pair = true}, 130.0f / 255.0f, 128.0f / 255.0f, 1.0f);
  EXPECT_NEAR(v.x, 130.0 / 255.0 * 2.0 - 1.0, 1e-6);
  EXPECT_NEAR(v.y, 128.0 / 255.0 * 2.0 - 1.0, 1e-6);  // a texel is flat only if both codes are flat
  EXPECT_EQ(v.z, 1.0);
}

TEST(NormalMapReading, SmallMapsWork) {
  const TemporaryFolder folder;
  const std::vector<std::pair<int, int>> sizes = {{1, 1}, {2, 2}, {1, 33}, {33, 1}, {3, 2}};
  for (const auto& [width, height] : sizes) {
    TestImage image = normal_image(width, height);
    image.type = TypeDesc::UINT16;
    write_test_image(folder / "small.png", image);
    const NormalMap map = read_map(folder / "small.png");
    EXPECT_LT(largest_difference(map, surface_normals(width, height)), 1e-4) << width << " x " << height;
  }
}

struct RefusalCase {
  const char* name;
  double r, g, b;  // mean colour
  double spread;   // uniform, +-
  const char* reason;
};

TEST(NormalMapReading, ColoursAreRefusedWithTheReason) {
  const TemporaryFolder folder;
  const unsigned seed = 20071;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const RefusalCase cases[] = {{"bricks", 0.6, 0.3, 0.2, 0.2, "below the surface"},
                               {"sky", 0.53, 0.81, 0.92, 0.03, "tilted to one side"},
                               {"white", 0.95, 0.93, 0.9, 0.05, "tilted to one side"},
                               {"lavender", 0.6, 0.5, 0.75, 0.05, "too few vectors"}};
  for (const RefusalCase& test : cases) {
    TestImage image;
    image.width = image.height = 64;
    for (int i = 0; i < 64 * 64; ++i)
      for (const double v : {test.r, test.g, test.b})
        image.values.push_back(static_cast<float>(std::clamp(v + test.spread * uniform(generator), 0.0, 1.0)));
    write_test_image(folder / "colour.png", image);
    SCOPED_TRACE(std::string(test.name) + ", seed " + std::to_string(seed));
    expect_error(ErrorCode::kInput,
                 {"colour.png", "neither a normal map nor a height field", test.reason, "expected", "--bumpformat"},
                 [&] { read_map(folder / "colour.png"); });
    NormalMapSettings settings;
    settings.bump_format = BumpFormat::kNormal;
    settings.repair_share_max = 1.0f;
    expect_unit_above_horizon(read_map(folder / "colour.png", settings));
  }
}

TEST(NormalMapReading, ObjectSpaceMapsAreRefused) {
  const TemporaryFolder folder;
  TestImage image;
  image.width = image.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    const double angle = 0.01 * i;
    const double z = 2.0 * ((i * 7) % 64) / 63.0 - 1.0;
    const double radius = std::sqrt(1.0 - z * z);
    for (const double v : {radius * std::cos(angle), radius * std::sin(angle), z})
      image.values.push_back(static_cast<float>(v * 0.5 + 0.5));
  }
  write_test_image(folder / "object.png", image);
  expect_error(ErrorCode::kInput, {"object-space"}, [&] { read_map(folder / "object.png"); });
}

// Directions of any length up to 1 without a third channel, as in an anisotropy map, are not the slopes of a surface.
TEST(NormalMapReading, FlowMapsAreRefused) {
  const TemporaryFolder folder;
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  TestImage image;
  image.width = image.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    const double angle = 6.283 * uniform(generator);
    const double radius = std::sqrt(uniform(generator));
    for (const double v : {radius * std::cos(angle), radius * std::sin(angle), -1.0})
      image.values.push_back(static_cast<float>(v * 0.5 + 0.5));
  }
  write_test_image(folder / "flow.png", image);
  expect_error(ErrorCode::kInput, {"not the slopes of a surface"}, [&] { read_map(folder / "flow.png"); });
}

TEST(NormalMapReading, OneChannelIsNoNormalMap) {
  const TemporaryFolder folder;
  TestImage image{.width = 2, .height = 2, .channels = 1, .values = {0.0f, 0.1f, 0.2f, 0.3f}};
  write_test_image(folder / "grey.png", image);
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kNormal;
  expect_error(ErrorCode::kInput, {"grey.png", "1 colour channel"}, [&] { read_map(folder / "grey.png", settings); });
  EXPECT_TRUE(contains(read_map(folder / "grey.png").report.encoding_reason, "looks like a height"));
}

TEST(NormalMapReading, TwoChannelsOfAGreyImageAreRefused) {
  const TemporaryFolder folder;
  TestImage image{.width = 8, .height = 8, .channels = 2, .channel_names = {"Y", "A"}, .alpha_channel = 1};
  for (int i = 0; i < 128; ++i) image.values.push_back(static_cast<float>(i) / 128.0f);
  write_test_image(folder / "ga.png", image);
  NormalMapSettings settings;
  settings.two_channel = true;
  expect_error(ErrorCode::kInput, {"ga.png", "png uint8", "2 channels", "1 colour channel", "red and green"},
               [&] { read_map(folder / "ga.png", settings); });
}

TEST(NormalMapReading, XInAlphaIsNamed) {
  const TemporaryFolder folder;
  const TestImage full = normal_image(64, 64);
  TestImage image{.width = 64, .height = 64, .channels = 4, .alpha_channel = 3};
  for (const float blue : {0.0f, 1.0f, -1.0f}) {  // -1 stands for a blue that equals green
    image.values.clear();
    for (std::size_t i = 0; i < full.values.size(); i += 3)
      image.values.insert(image.values.end(),
                          {1.0f, full.values[i + 1], blue < 0.0f ? full.values[i + 1] : blue, full.values[i]});
    write_test_image(folder / "dxt5nm.png", image);
    expect_error(ErrorCode::kInput, {"dxt5nm.png", "a constant red and an alpha", "x in alpha", "expected x in red"},
                 [&] { read_map(folder / "dxt5nm.png"); });
  }
}

// Scaling follows glTF's normalTexture.scale: x and y are multiplied, and then the normal is normalised. The detected
// encoding does not change.
TEST(NormalMapReading, NormalsAreScaled) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.exr", normal_image(32, 16, true));
  NormalMapSettings settings;
  const NormalMap plain = read_map(folder / "a.exr");
  for (const float scale : {0.0f, 0.5f, 2.0f, -1.0f}) {
    settings.normal_scale = scale;
    const NormalMap scaled = read_map(folder / "a.exr", settings);
    EXPECT_TRUE(contains(scaled.report.encoding, "scaled by")) << scaled.report.encoding;
    for (std::size_t i = 0; i < plain.x.size(); ++i) {
      const glm::vec3 expected = glm::normalize(glm::vec3(scale * plain.x[i], scale * plain.y[i], plain.z[i]));
      ASSERT_NEAR(scaled.x[i], expected.x, 1e-6f) << i;
      ASSERT_NEAR(scaled.y[i], expected.y, 1e-6f) << i;
      ASSERT_NEAR(scaled.z[i], expected.z, 1e-6f) << i;
    }
  }
  settings.normal_scale = kNan;
  expect_error(ErrorCode::kUsage, {"--normal-scale"}, [&] { read_map("x", settings); });
  write_test_image(folder / "heights.png", TestImage{.width = 2, .height = 1, .channels = 1, .values = {0, 1}});
  settings = {};
  settings.bump_format = BumpFormat::kHeight;
  settings.normal_scale = 2.0f;
  const std::vector<std::string> warnings = read_map(folder / "heights.png", settings).report.warnings;
  ASSERT_FALSE(warnings.empty());
  expect_says(warnings[0], {"--normal-scale", "no effect", "height field"});
}

TEST(NormalMapReading, OptionsWithoutEffectAreNamed) {
  const TemporaryFolder folder;
  TestImage grey{.width = 8, .height = 8, .channels = 1};
  for (int i = 0; i < 64; ++i) grey.values.push_back(static_cast<float>(i) / 64.0f);
  write_test_image(folder / "grey.png", grey);
  NormalMapSettings settings;
  settings.green = GreenAxis::kUp;
  settings.is_signed = false;
  const std::string found = warnings(read_map(folder / "grey.png", settings));
  expect_says(found, {"--green", "--unsigned", "no effect", "height field"});
  settings = {};
  settings.bump_format = BumpFormat::kHeight;
  settings.is_signed = true;
  settings.two_channel = true;
  expect_says(warnings(read_map(folder / "grey.png", settings)), {"--signed", "--two-channel", "no effect"});

  write_test_image(folder / "normals.png", normal_image(64, 64));
  settings = {};
  EXPECT_EQ(warnings(read_map(folder / "normals.png", settings)), "");
  settings.height_scale = 8.0f;
  const std::string scale_warning = warnings(read_map(folder / "normals.png", settings));
  expect_says(scale_warning, {"--height-scale", "no effect", "normal map"});
  EXPECT_EQ(scale_warning.find('\n'), scale_warning.size() - 1) << "one warning: " << scale_warning;
}

TEST(NormalMapReading, SettingsOutOfRangeAreRefused) {
  NormalMapSettings settings;
  settings.height_scale = 0.0f;
  expect_error(ErrorCode::kUsage, {"--height-scale"}, [&] { read_map("x", settings); });
  settings.height_scale = kNan;
  expect_error(ErrorCode::kUsage, {"--height-scale"}, [&] { read_map("x", settings); });
  settings = {};
  settings.repair_share_max = 1.5f;
  expect_error(ErrorCode::kUsage, {"--repair-max", "1.5"}, [&] { read_map("x", settings); });
  settings = {};
  settings.texel_count_max = 0;
  expect_error(ErrorCode::kUsage, {"texel_count_max"}, [&] { read_map("x", settings); });
}

// Makes a signed float map with every kind of hole at known positions.
class NormalRepair : public ::testing::Test {
 protected:
  void SetUp() override {
    image_ = normal_image(64, 64, true);
    image_.type = TypeDesc::FLOAT;
  }
  void set(int column, int row, float x, float y, float z) {
    image_.at(column, row, 0) = x;
    image_.at(column, row, 1) = y;
    image_.at(column, row, 2) = z;
  }
  NormalMap read(const NormalMapSettings& settings = {}) {
    write_test_image(folder_ / "a.exr", image_);
    return read_map(folder_ / "a.exr", settings);
  }
  glm::dvec3 normal(const NormalMap& map, int column, int row) const {
    const auto i = static_cast<std::size_t>(row * 64 + column);
    return {map.x[i], map.y[i], map.z[i]};
  }
  TemporaryFolder folder_;
  TestImage image_;
};

TEST_F(NormalRepair, NonfiniteTexelsByEachRule) {
  set(10, 20, kNan, 0, 1);
  set(30, 40, 0, kInf, 1);
  set(30, 41, 0, 0, -kInf);
  const NormalMap box = read();
  EXPECT_EQ(box.report.nonfinite_repaired, 3);
  EXPECT_EQ(box.report.zero_length_repaired, 0);
  EXPECT_EQ(box.report.below_horizon_repaired, 0);
  EXPECT_LT(largest_difference(box, surface_normals(64, 64)), 0.1);  // the neighbours' mean is near the lost normal
  NormalMapSettings settings;
  settings.fix_nan = FixNan::kBlack;
  const NormalMap flat = read(settings);
  EXPECT_EQ(normal(flat, 10, 20), glm::dvec3(0, 0, 1));
  EXPECT_EQ(flat.report.nonfinite_repaired, 3);
  settings.fix_nan = FixNan::kNone;
  const std::vector<std::string> parts = {"a.exr", "NaN or Inf", "column 10, row 20", "3 texels"};
  expect_error(ErrorCode::kInput, parts, [&] { read(settings); });
  settings = {};
  settings.check_nan = true;
  expect_error(ErrorCode::kInput, parts, [&] { read(settings); });
}

TEST_F(NormalRepair, ZeroLengthTakesTheNeighboursMean) {
  set(5, 5, 0, 0, 0);
  const NormalMap map = read();
  EXPECT_EQ(map.report.zero_length_repaired, 1);
  EXPECT_EQ(repair_count(map), 1);
  EXPECT_LT(largest_difference(map, surface_normals(64, 64)), 0.1);
}

TEST_F(NormalRepair, AHoleWithoutNeighboursIsFlat) {
  for (int row = 10; row < 13; ++row)
    for (int column = 10; column < 13; ++column) set(column, row, kNan, kNan, kNan);
  const NormalMap map = read();
  EXPECT_EQ(map.report.nonfinite_repaired, 9);
  EXPECT_EQ(normal(map, 11, 11), glm::dvec3(0, 0, 1));
  EXPECT_NE(normal(map, 10, 10), glm::dvec3(0, 0, 1));
}

TEST_F(NormalRepair, BelowTheHorizonIsLiftedToIt) {
  set(1, 2, 0.6f, 0.0f, -0.8f);
  set(3, 4, 0.0f, 0.0f, -1.0f);
  const NormalMap map = read();
  EXPECT_EQ(map.report.below_horizon_repaired, 2);
  EXPECT_NEAR(normal(map, 1, 2).x, std::sqrt(1.0 - kHorizonZ * kHorizonZ), 1e-6);
  EXPECT_NEAR(normal(map, 1, 2).z, kHorizonZ, 1e-8);
  EXPECT_EQ(normal(map, 3, 4), glm::dvec3(0, 0, 1));
  expect_unit_above_horizon(map);
}

TEST_F(NormalRepair, TooManyRepairsRefuseTheFileWithTheCounts) {
  for (int i = 0; i < 40; ++i) set(i, 8, kNan, 0, 1);
  read();  // 40 of 4096 are 0.98 %
  set(0, 0, 0, 0, 0);
  expect_error(ErrorCode::kInput,
               {"a.exr", "41 of 4096", "1.00 %", "40 not finite", "1 of zero length", "--repair-max"}, [&] { read(); });
  NormalMapSettings settings;
  settings.repair_share_max = 0.02f;
  EXPECT_EQ(repair_count(read(settings)), 41);
}

TEST_F(NormalRepair, UnitLengthWhateverTheFileHas) {
  for (float& v : image_.values) v *= 1.04f;
  const NormalMap map = read();
  EXPECT_EQ(repair_count(map), 0);
  EXPECT_LT(largest_difference(map, surface_normals(64, 64)), 1e-6);
}

// The black area between the charts of an atlas does not count as evidence or as damage.
TEST(NormalMapReading, UnusedTexelsAreFlatAndNoRepairs) {
  const TemporaryFolder folder;
  TestImage image = normal_image(64, 64);
  const auto blacken = [&](int row_end) {
    for (int row = 0; row < row_end; ++row)
      for (int column = 0; column < 64; ++column)
        for (int channel = 0; channel < 3; ++channel)
          image.at(column, row, channel) = static_cast<float>(column % 5) / 255.0f;
    write_test_image(folder / "atlas.png", image);
  };
  for (int column = 0; column < 40; ++column)
    for (int channel = 0; channel < 3; ++channel) image.at(column, 63, channel) = 0.0f;
  write_test_image(folder / "atlas.png", image);
  EXPECT_EQ(read_map(folder / "atlas.png").report.unused_texels, 40);
  EXPECT_EQ(warnings(read_map(folder / "atlas.png")), "");  // 0.98 %
  blacken(31);
  const NormalMap map = read_map(folder / "atlas.png");
  EXPECT_EQ(map.report.unused_texels, 31 * 64 + 40);
  EXPECT_EQ(repair_count(map), 0);
  EXPECT_EQ(map.z[0], 1.0f);
  EXPECT_EQ(map.x[0], 0.0f);
  expect_says(warnings(map), {"2024 of 4096", "49.4 %", "black"});
  blacken(33);
  expect_error(ErrorCode::kInput, {"atlas.png", "2152 of 4096", "52.5 %", "black", "50 %"},
               [&] { read_map(folder / "atlas.png"); });
  NormalMapSettings settings;
  settings.bump_format = BumpFormat::kNormal;
  EXPECT_EQ(read_map(folder / "atlas.png", settings).report.unused_texels, 33 * 64 + 40);
}

TEST(NormalMapReading, MidGreyIsZeroLength) {
  const TemporaryFolder folder;
  TestImage image = normal_image(64, 64);
  for (int channel = 0; channel < 3; ++channel) image.at(9, 9, channel) = 128.0f / 255.0f;
  write_test_image(folder / "a.png", image);
  EXPECT_EQ(read_map(folder / "a.png").report.zero_length_repaired, 1);
}

TEST(NormalMapReading, ThreadCountChangesNoBit) {
  const TemporaryFolder folder;
  TestImage image = normal_image(123, 157, true, -1.0);
  image.type = TypeDesc::HALF;
  for (int i = 0; i < 50; ++i) image.at((i * 31) % 123, (i * 17) % 157, i % 3) = i % 2 == 0 ? kNan : -2.0f;
  write_test_image(folder / "a.exr", image);
  const NormalMap one = read_normal_map(folder / "a.exr", {}, 1, nullptr);
  EXPECT_GT(repair_count(one), 30);
  for (const int threads : {0, 2, 7}) {
    const NormalMap many = read_normal_map(folder / "a.exr", {}, threads, nullptr);
    EXPECT_EQ(one.x, many.x);
    EXPECT_EQ(one.y, many.y);
    EXPECT_EQ(one.z, many.z);
    EXPECT_EQ(one.report.encoding_reason, many.report.encoding_reason);
  }
}

TEST(NormalMapReading, CancelThrowsCancelled) {
  const TemporaryFolder folder;
  write_test_image(folder / "a.png", normal_image(64, 64));
  int calls = 0;
  for (int stop_at = 1; stop_at <= 4; ++stop_at) {
    calls = 0;
    Progress progress([&](const ProgressEvent&) { return ++calls < stop_at; });
    EXPECT_THROW(read_normal_map(folder / "a.png", {}, 2, &progress), Cancelled) << stop_at;
  }
}

}  // namespace
}  // namespace multum::testing
