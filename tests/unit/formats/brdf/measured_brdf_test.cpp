// SPDX-License-Identifier: Apache-2.0
// Tests reading, factoring and refusing measured BRDFs of all three formats, which this test makes. Also tests
// environment files.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "host/formats/brdf/measured_factors.h"
#include "host/formats/brdf/measured_file.h"
#include "host/formats/image/files/environment_file.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/comma_locale.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

class MeasuredFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("multum_measured_{}_{}", getpid(), static_cast<void*>(this));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  template <typename Read>
  void expect_refusal(const Read& read, const std::string& path, std::vector<std::string> parts) {
    parts.push_back(path);
    testing::expect_error(ErrorCode::kInput, parts, [&] { read(path); });
  }
  fs::path folder_;
};

// The BRDF is 0.2 / pi + f(theta_h) g(theta_d): f is Blinn-Phong with exponent 60, and g = 1 + 0.5 sin^2 theta_d.
double made_facets(double theta) { return 0.5 * 61.0 / (2.0 * std::numbers::pi) * std::pow(std::cos(theta), 60.0); }
double made_rho(double theta_h, double theta_d) {
  return 0.2 / std::numbers::pi + made_facets(theta_h) * (1.0 + 0.5 * std::pow(std::sin(theta_d), 2.0));
}

void expect_made(const MeasuredBrdf& brdf, double tolerance) {
  EXPECT_NEAR(brdf.diffuse.y, 0.2, 0.2 * tolerance);
  const double ratio = measured_facets(brdf, 0.0).y / made_facets(0.0);
  for (const double theta : {0.05, 0.15, 0.3})
    EXPECT_NEAR(measured_facets(brdf, 1.0 - std::cos(theta)).y / made_facets(theta) / ratio, 1.0, tolerance) << theta;
  EXPECT_NEAR(measured_differences(brdf, std::cos(1.0)) / measured_differences(brdf, std::cos(0.1)),
              (1.0 + 0.5 * std::pow(std::sin(1.0), 2.0)) / (1.0 + 0.5 * std::pow(std::sin(0.1), 2.0)), tolerance);
  EXPECT_LT(brdf.relative_error, tolerance);
}

TEST_F(MeasuredFileTest, TextOfSamples) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::string text = "# made\n5\n400 475 550 625 700\n";
  for (int i = 0; i < 40000; ++i) {
    // Makes pairs near mirror directions, and other pairs.
    const double theta = 1.4 * unit(random), phi = 2.0 * std::numbers::pi * unit(random);
    const bool near = i % 2 == 0;
    const double theta_s = near ? std::abs(theta + 0.4 * (unit(random) - 0.5)) : 1.4 * unit(random);
    const double phi_s =
        near ? phi + std::numbers::pi + 0.4 * (unit(random) - 0.5) : 2.0 * std::numbers::pi * unit(random);
    const glm::dvec3 l(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    const glm::dvec3 v(std::sin(theta_s) * std::cos(phi_s), std::sin(theta_s) * std::sin(phi_s), std::cos(theta_s));
    double theta_h = 0.0, theta_d = 0.0;
    half_angles(l, v, &theta_h, &theta_d);
    const double rho = made_rho(theta_h, theta_d);
    text += fmt::format("{:.6f} {:.6f} {:.6f} {:.6f}", theta, phi, theta_s, phi_s);
    for (int k = 0; k < 5; ++k) text += fmt::format(" {:.6f}", rho);
    text += "\n";
  }
  const MeasuredBrdf brdf = read_measured_brdf(write("made.brdf", text));
  expect_made(brdf, 0.08);
  EXPECT_NEAR(brdf.diffuse.x, brdf.diffuse.z, 1e-3) << "a flat spectrum is white";
}

TEST_F(MeasuredFileTest, BinaryOfMerl) {
  constexpr int kCount = 90 * 90 * 180;
  std::vector<double> values(3 * kCount);
  for (int h = 0; h < 90; ++h)
    for (int d = 0; d < 90; ++d) {
      const double x = (h + 0.5) / 90.0,
                   rho = made_rho(0.5 * std::numbers::pi * x * x, 0.5 * std::numbers::pi * (d + 0.5) / 90.0);
      for (int p = 0; p < 180; ++p) {
        const auto i = static_cast<std::size_t>(p + 180 * (d + 90 * h));
        values[i] = 1500.0 * rho;
        values[i + kCount] = 1500.0 / 1.15 * rho;
        values[i + 2 * kCount] = p % 7 == 0 ? -1.0 : 1500.0 / 1.66 * rho;  // not measured
      }
    }
  const std::int32_t sizes[3] = {90, 90, 180};
  std::string bytes(reinterpret_cast<const char*>(sizes), sizeof(sizes));
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  expect_made(read_measured_brdf(write("made.binary", bytes)), 0.05);
  expect_refusal(read_measured_brdf, write("cut.binary", bytes.substr(0, bytes.size() - 8)), {"cut"});
}

TEST_F(MeasuredFileTest, NetworkOfAFit) {
  // One hidden unit per layer passes hz on: rho = exp(4 hz - 4) - 1 + ..., clamped at 0, a function of theta_h.
  nlohmann::json file;
  file["layers"] = {{{"kernel", {{0.0}, {0.0}, {1.0}, {0.0}, {0.0}, {0.0}}}, {"bias", {0.0}}},
                    {{"kernel", {{4.0, 4.0, 2.0}}}, {"bias", {-2.0, -2.0, -1.0}}}};
  const MeasuredBrdf brdf = read_measured_brdf(write("fit.json", file.dump()));
  for (const double theta : {0.0, 0.3, 0.6})
    EXPECT_NEAR(brdf.diffuse.x / std::numbers::pi + measured_facets(brdf, 1.0 - std::cos(theta)).x,
                std::expm1(4.0 * std::cos(theta) - 2.0), 0.05)
        << theta;
  file["layers"][0]["bias"] = {0.0, 1.0};
  expect_refusal(read_measured_brdf, write("wrong.json", file.dump()), {"kernel", "6 rows"});
  expect_refusal(read_measured_brdf, write("empty.json", "{\"layers\": []}"), {"red", "green", "blue"});
  expect_refusal(read_measured_brdf, write("broken.json", "{\"layers\": [}         "), {"JSON"});
}

TEST_F(MeasuredFileTest, RefusesWhatIsNoMeasurement) {
  expect_refusal(read_measured_brdf, (folder_ / "none.brdf").string(), {"no such"});
  expect_refusal(read_measured_brdf, folder_.string(), {"is a folder"});
  expect_refusal(read_measured_brdf, write("word.brdf", "3\n400 550 seven\n1 2 3 4 5 6 7"), {"line 2", "numbers"});
  expect_refusal(read_measured_brdf, write("count.brdf", "2.5 400 500 600 1 2 3 4"), {"wavelengths", "2.5"});
  expect_refusal(read_measured_brdf, write("cut.brdf", "3 400 550 700 0.1 0.2 0.3 0.4 0.5 0.6"), {"rows", "7"});
  expect_refusal(read_measured_brdf, write("infrared.brdf", "3 900 1000 1100 .1 .2 .3 .4 .5 .6 .7"),
                 {"red, green and blue"});
  expect_refusal(read_measured_brdf, write("below.brdf", "5 400 475 550 625 700 3 0 3 0 .5 .5 .5 .5 .5"), {"horizon"});
}

std::string radiance(const std::string& size, const std::string& rows) {
  return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n" + size + "\n" + rows;
}

TEST_F(MeasuredFileTest, RadianceRows) {
  // In a packed row of 8 texels, red is 128 in all texels. Green is stored as 3 and then 5 single values. Blue is 64 in
  // all texels. All exponents are 129, which scales a value by 2^-7.
  const std::string packed = std::string("\2\2\0\x8", 4) + std::string("\x88\x80", 2) +
                             std::string("\x3\1\2\3\x5\4\5\6\7\x8", 10) + std::string("\x88\x40", 2) +
                             std::string("\x88\x81", 2);
  std::string flat;
  for (int i = 0; i < 8; ++i) flat += std::string("\x10\x20\x30\x80", 4);
  const ColourMap map = read_environment_map(write("made.hdr", radiance("-Y 4 +X 8", packed + flat + packed + flat)));
  ASSERT_EQ(map.width, 8);
  ASSERT_EQ(map.r.size(), 32u);
  EXPECT_EQ(map.r[0], 0.5f);  // 128 / 128, divided by the exposure
  EXPECT_EQ(map.g[2], 3.0f / 256.0f);
  EXPECT_EQ(map.g[7], 8.0f / 256.0f);
  EXPECT_EQ(map.b[15], 48.0f / 512.0f);
  const auto refusal = [&](const std::string& size, const std::string& rows, const std::vector<std::string>& parts) {
    expect_refusal(read_environment_map, write("bad.hdr", radiance(size, rows)), parts);
  };
  refusal("-Y 4 +X 8", packed + flat + packed, {"cut"});
  refusal("-Y 4 +X 9", packed, {"9", "4", "wide"});
  refusal("+Y 4 +X 8", packed, {"+Y", "-Y", "+X"});
  refusal("-Y 4 +X 8", std::string("\2\2\0\x8\x89\x80", 6), {"run extends beyond", "row"});
  refusal("-Y 999999 +X 1999998", packed, {"1999998", "999999", "wide"});
  expect_refusal(read_environment_map, write("xyz.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 4 +X 8\n"), {"xyze"});
  expect_refusal(read_environment_map, write("none.hdr", "#?"), {"header"});
}

TEST_F(MeasuredFileTest, DecimalCommaOfTheHostProgram) {
  const testing::CommaLocale locale(folder_.string());
  if (!locale.is_set()) GTEST_SKIP() << "no locale with a decimal comma, and localedef cannot make one";
  // The numbers are read, because only the direction below the horizon is refused.
  expect_refusal(read_measured_brdf, write("below.brdf", "5 400 475.5 550 625 700 3 0 3 0 .5 .5 .5 .5 .5"),
                 {"horizon"});
  std::string flat;
  for (int i = 0; i < 8; ++i) flat += std::string("\x10\x20\x30\x80", 4);
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=0.5\n\n-Y 4 +X 8\n";
  const ColourMap map = read_environment_map(write("made.hdr", head + flat + flat + flat + flat));
  EXPECT_EQ(map.r[0], 0.125f);  // 16 / 256, divided by the exposure
}

}  // namespace
}  // namespace multum
