// SPDX-License-Identifier: Apache-2.0
// Makes a folder with a small baked map and runs multum-view in it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "host/foundation/base/processes/child_process.h"
#include "tests/gl/test_maps.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {

class ViewTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              (std::string("multum_view_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    gl::TestMap map = gl::make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false);
    write_movmf_mipmap(path("map.ndf.exr"), map.mipmap, {});
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static ChildResult run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum-view");
    return run_child(arguments);
  }
  ChildResult view(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), path("map.ndf.exr"));
    return run(arguments);
  }
  void expect_refusal(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& parts) const {
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, code) << result.output;
    expect_says(result.output, parts);
    EXPECT_FALSE(std::filesystem::exists(path("out.png")));
  }
  /// Writes sky.hdr, which is blue above the horizon and brown below it.
  void write_sky() const {
    std::string sky = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
    for (int i = 0; i < 128; ++i) sky += i < 64 ? "\x60\x80\xC0\x81" : "\x40\x30\x20\x7F";
    std::ofstream(path("sky.hdr"), std::ios::binary) << sky;
  }
  /// Writes night.hdr, which has the same size. Only one half of the horizon is bright, so that a rotation of the
  /// environment is visible.
  void write_night() const {
    std::string night = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
    for (int i = 0; i < 128; ++i) night += i % 16 < 8 ? "\x20\x40\xC0\x81" : "\x40\x30\x20\x7B";
    std::ofstream(path("night.hdr"), std::ios::binary) << night;
  }
  std::filesystem::path folder_;
};

}  // namespace multum::testing
