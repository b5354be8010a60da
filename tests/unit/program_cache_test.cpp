// SPDX-License-Identifier: Apache-2.0
// Kept program binaries save a build and are never a reason to fail.
#include "host/opencl/program_cache.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/content_hash.h"
#include "host/base/log.h"
#include "host/opencl/device.h"
#include "kernels/shared/movmf_fit.h"
#include "tests/unit/test_folder.h"

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

  // Builds or loads the smallest program and runs it; returns what was said.
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
    // One texel without a parent: lobe 0 takes it.
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
  // Where the file itself should be there is a folder of that name.
  use(folder / "cache");
  const std::string path =
      folder / "cache/" + std::filesystem::directory_iterator(folder / "cache")->path().filename().string();
  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  EXPECT_NE(use(folder / "cache").find("is a folder"), std::string::npos);
}

}  // namespace
}  // namespace multum
