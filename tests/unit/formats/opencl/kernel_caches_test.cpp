// SPDX-License-Identifier: Apache-2.0
// Tests that a private folder is used if the folders for compiled kernels are not writable. tests/cli/limits_test.cpp
// tests that the program removes it.
#include "host/formats/opencl/kernel_caches.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "host/formats/opencl/program_cache.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::TemporaryFolder;

/// Restores the environment variables when it is destroyed.
class KernelCachesTest : public ::testing::Test {
 protected:
  ~KernelCachesTest() override {
    for (const Kept& one : kept_)
      if (one.is_set) ::setenv(one.name, one.value.c_str(), 1);
      else ::unsetenv(one.name);
    set_kernel_caches({});
  }
  static std::string prepared(const KernelCacheFolders& folders) {
    set_kernel_caches(folders);
    ::testing::internal::CaptureStderr();
    prepare_kernel_caches();
    prepare_kernel_caches();  // does not print another message
    return ::testing::internal::GetCapturedStderr();
  }

 private:
  struct Kept {
    explicit Kept(const char* variable) : name(variable), is_set(std::getenv(name) != nullptr) {
      if (is_set) value = std::getenv(name);
    }
    const char* name;
    bool is_set;
    std::string value;
  };
  const Kept kept_[2] = {Kept("MULTUM_CACHE_DIR"), Kept("POCL_CACHE_DIR")};
};

TEST_F(KernelCachesTest, FoldersThatCanBeWrittenAreTaken) {
  const TemporaryFolder folder;
  ::setenv("MULTUM_CACHE_DIR", "as it was", 1);
  EXPECT_EQ(prepared({folder / "new/multum", folder / "new/pocl"}), "");
  EXPECT_STREQ(std::getenv("MULTUM_CACHE_DIR"), "as it was");
  EXPECT_EQ(folder.names(), testing::Names{"new"}) << "the folder was made and is empty";
  EXPECT_TRUE(std::filesystem::is_empty(folder / "new/multum"));
  EXPECT_EQ(pocl_cache_failure(), "");
}

// Nobody can make a folder below a file, not even root.
TEST_F(KernelCachesTest, APrivateFolderReplacesOneThatCannotBeWritten) {
  const TemporaryFolder folder;
  testing::write_bytes(folder / "file", "no folder");
  const std::string said = prepared({folder / "file/multum", folder / "file/pocl"});
  testing::expect_says(
      said, {folder / "file/multum", "Not a directory", "MULTUM_CACHE_DIR", folder / "file/pocl", "POCL_CACHE_DIR"});
  const std::filesystem::path programs = std::getenv("MULTUM_CACHE_DIR"), pocl = std::getenv("POCL_CACHE_DIR");
  EXPECT_EQ(programs.parent_path(), pocl.parent_path());
  struct stat status = {};
  ASSERT_EQ(::stat(programs.parent_path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777u, 0700u) << "nobody else may write kernels that run here";
  EXPECT_TRUE(std::filesystem::is_directory(pocl));
  EXPECT_EQ(pocl_cache_failure(), "");
  EXPECT_EQ(prepared({programs.string(), pocl.string()}), "") << "children inherit the variables";
}

TEST_F(KernelCachesTest, NoFoldersAreNoConcern) { EXPECT_EQ(prepared({}), ""); }

}  // namespace
}  // namespace multum
