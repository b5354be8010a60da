// SPDX-License-Identifier: Apache-2.0
// Tests that cached program binaries avoid a build and never cause a failure.
#include "host/formats/opencl/program_cache.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/log.h"
#include "kernels/shared/movmf_fit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

class ProgramCacheTest : public ::testing::Test {
 protected:
  ~ProgramCacheTest() override {
    set_program_cache_folder("");
    set_log_level(LogLevel::kNormal);
  }

  // Builds or loads the smallest program and runs it; returns the messages.
  static std::string use(const std::string& cache_folder) {
    set_program_cache_folder(cache_folder);
    set_log_level(LogLevel::kVerbose);
    ::testing::internal::CaptureStderr();
    Device device = Device::open("");
    Kernel kernel = device.kernel("movmf_level_zero", "movmf_level_zero", KernelVariant{1, 1, false});
    const std::vector<float> zeros(16, 0.0f), ones(16, 1.0f);
    DeviceBuffer x = device.make_buffer(64, "x"), y = device.make_buffer(64, "y"), z = device.make_buffer(64, "z");
    device.write(x, zeros.data(), 64);
    device.write(y, zeros.data(), 64);
    device.write(z, ones.data(), 64);
    DeviceBuffer parent = device.make_buffer(64, "lobes"), nearest = device.make_buffer(1, "numbers of lobes");
    unsigned char lobe = 255;
    device.write(nearest, &lobe, 1);
    // In the only texel, which has no parent, lobe 0 gets all normals.
    MultumMovmfFit fit{};
    fit.map_width = fit.map_height = fit.width = fit.height = fit.window_rows = 1;
    kernel.launch({1}, x, y, z, parent, nearest, fit, 0, 0, 0, 1);
    device.read(nearest, &lobe, 1);
    EXPECT_EQ(lobe, 0);
    return ::testing::internal::GetCapturedStderr();
  }

  static std::string only_file(const TemporaryFolder& folder) {
    EXPECT_EQ(folder.names().size(), 1u) << "one program, no temporary files";
    return folder.names().empty() ? "" : folder / *folder.names().begin();
  }
};

TEST_F(ProgramCacheTest, TheSecondRunLoads) {
  const TemporaryFolder folder;
  EXPECT_EQ(use(folder.path()).find("loaded"), std::string::npos);
  only_file(folder);
  EXPECT_NE(use(folder.path()).find("movmf_level_zero loaded"), std::string::npos);
}

TEST_F(ProgramCacheTest, DamagedBinariesAreBuiltAnew) {
  const TemporaryFolder folder;
  use(folder.path());
  const std::string path = only_file(folder), whole = read_bytes(path);
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
  const std::string garbage(1000, 'x');
  for (const std::string& damaged : {flipped, whole.substr(0, whole.size() / 2), std::string(), std::string(64, 'x'),
                                     garbage, garbage + hash_text(garbage)}) {
    SCOPED_TRACE(damaged.size());
    write_bytes(path, damaged);
    EXPECT_EQ(use(folder.path()).find("loaded"), std::string::npos);
    EXPECT_NE(read_bytes(only_file(folder)), damaged) << "the damaged file was replaced";
    EXPECT_NE(use(folder.path()).find("loaded"), std::string::npos);
  }
}

TEST_F(ProgramCacheTest, AFolderThatCannotBeMadeCostsOnlyTheBuild) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "");
  EXPECT_NE(use(folder / "file/cache").find("program cache: "), std::string::npos);
  EXPECT_EQ(folder.names(), std::set<std::string>{"file"});
  // A folder has the name of the cache file.
  use(folder / "cache");
  const std::string path =
      folder / "cache/" + std::filesystem::directory_iterator(folder / "cache")->path().filename().string();
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  EXPECT_NE(use(folder / "cache").find("is a folder"), std::string::npos);
}

TEST_F(ProgramCacheTest, WhatIsPreparedIsBuiltOnceAndKept) {
  const TemporaryFolder folder;
  set_program_cache_folder(folder.path());
  const KernelVariant variant{1, 1, false};
  {
    ::testing::internal::CaptureStderr();
    Device device = Device::open("");
    device.prepare({{"movmf_level_zero", variant}, {"moments", variant}, {"movmf_level_zero", variant}});
    device.prepare({{"moments", variant}});
    device.kernel("movmf_level_zero", "movmf_level_zero", variant);
    device.kernel("moments", "moment_finest", variant);
    EXPECT_EQ(device.unprepared_count(), 0);
    device.kernel("mip_box", "mip_texels", variant);
    EXPECT_EQ(device.unprepared_count(), 1) << "this program was not prepared";
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("compiling kernels for " + device.info().name), std::string::npos) << said;
    EXPECT_EQ(said.find("compiling"), said.rfind("compiling")) << "once: " << said;
  }
  EXPECT_EQ(folder.names().size(), 3u);
  ::testing::internal::CaptureStderr();
  Device device = Device::open("");
  device.prepare({{"movmf_level_zero", variant}, {"moments", variant}});
  device.kernel("moments", "moment_finest", variant);
  EXPECT_EQ(device.unprepared_count(), 0);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "") << "nothing was compiled";
}

TEST_F(ProgramCacheTest, WhatIsPreparedAndNeverAskedForHoldsNobodyUp) {
  const TemporaryFolder folder;
  set_program_cache_folder(folder.path());
  std::vector<ProgramChoice> many;
  for (int order = 1; order <= 20; ++order) many.push_back({"sh_project", {1, 1, false, false, order}});
  {
    Device device = Device::open("");
    device.prepare(many);
  }  // waits only for builds that are running
  EXPECT_LT(folder.names().size(), many.size());
}

TEST_F(ProgramCacheTest, AProgramThatDoesNotBuildIsToldToWhoAsksForIt) {
  const TemporaryFolder folder;
  set_program_cache_folder(folder.path());
  Device device = Device::open("");
  device.edit_kernels({{"movmf_level_zero", "__kernel", "no kernel;"}});
  device.prepare({{"movmf_level_zero", {1, 1, false}}});
  try {
    device.kernel("movmf_level_zero", "movmf_level_zero", {1, 1, false});
    FAIL() << "it was built";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
    EXPECT_NE(std::string(error.what()).find("movmf_level_zero.cl"), std::string::npos) << error.what();
  }
  EXPECT_EQ(folder.names().size(), 0u);
}

// The first bake on a machine builds exactly the kernels that it launches, and builds them in parallel.
TEST_F(ProgramCacheTest, ABakePreparesWhatItLaunches) {
  constexpr int kWidth = 256, kHeight = 192;  // large enough for binned and weighted levels
  NormalMap map;
  map.width = kWidth;
  map.height = kHeight;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const double at = i;
    const glm::vec3 normal = glm::normalize(glm::vec3(0.4 * std::sin(at), 0.4 * std::cos(1.7 * at), 1.0));
    map.x.push_back(normal.x);
    map.y.push_back(normal.y);
    map.z.push_back(normal.z);
  }
  const std::vector<float> grey(map.x.size(), 0.5f);
  const ColourMap colours{kWidth, kHeight, grey, grey, grey, "", 0, {}};
  for (const bool coloured : {false, true}) {
    SCOPED_TRACE(coloured);
    const TemporaryFolder folder;
    set_program_cache_folder(folder.path());
    Device device = Device::open(DeviceChoice{"", coloured});  // one device acts as an accelerator
    MovmfSettings settings;
    settings.lobe_count = 2;
    FitReport report;
    bake_movmf(device, map, coloured ? &colours : nullptr, settings, report, nullptr);
    EXPECT_EQ(device.unprepared_count(), 0);
    EXPECT_EQ(static_cast<std::size_t>(device.program_count()), folder.names().size())
        << "a program was built but never used";
    EXPECT_GE(device.program_count(), 5);
  }
}

}  // namespace
}  // namespace multum
