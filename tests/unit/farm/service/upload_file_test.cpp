// SPDX-License-Identifier: Apache-2.0
// Tests that an upload is refused if the disk is full, and that no part of it is kept.
#include "host/farm/service/files/upload_file.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>
#include <memory>

#include "host/farm/service/dispatch/data_folder.h"
#include "host/farm/service/files/network_disk.h"
#include "host/farm/service/files/no_space.h"
#include "host/farm/service/http/http_reply.h"
#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::FileLimit;
using testing::TemporaryFolder;

TEST(UploadFileTest, ALimitOfFileSizesIsNoSpace) {
  const TemporaryFolder folder;
  DataFolder data(folder / "d", 0);
  {
    const std::shared_ptr<UploadFile> file = data.begin_upload(2 << 20);
    const FileLimit limit(1 << 20);
    try {
      for (int i = 0; i < 32; ++i) file->write(std::string(1 << 16, 'a'));
      FAIL() << "an upload above the limit was accepted";
    } catch (const Error& error) {
      const Refusal refusal = refusal_of(error);
      EXPECT_EQ(refusal.status, 507);
      EXPECT_EQ(refusal.code, "no_space");
      testing::expect_says(refusal.message, {"File too large", "ulimit -f"});
    }
  }
  EXPECT_TRUE(fs::is_empty(data.uploads()));
  const std::shared_ptr<UploadFile> small = data.begin_upload(100);
  small->write("content");
  EXPECT_EQ(testing::read_bytes(data.store("a.png", *small).path), "content") << "and it goes on";
}

TEST(UploadFileTest, WhatNoSpaceIs) {
  for (const int error : {ENOSPC, EDQUOT, EFBIG}) {
    EXPECT_TRUE(is_no_space(error));
    errno = error;
    EXPECT_THROW(fail_to_write("a", "b"), NoSpaceError);
  }
  errno = EACCES;
  try {
    fail_to_write("a", "b");
  } catch (const Error& error) {
    EXPECT_EQ(refusal_of(error).status, 503);
  }
}

TEST(NetworkDiskTest, DisksOfThisMachineAreTold) {
  EXPECT_EQ(network_disk_name(0x6969), "NFS");
  EXPECT_EQ(network_disk_name(0xff534d42), "CIFS");
  EXPECT_EQ(network_disk_name(static_cast<std::int32_t>(0xff534d42)), "CIFS") << "f_type with a sign";
  EXPECT_EQ(network_disk_name(0x0bd00bd0), "Lustre");
  EXPECT_NE(network_disk_name(0x65735546), "");  // FUSE
  // ext4, XFS, Btrfs, ZFS, tmpfs, overlayfs, bcachefs, F2FS
  for (const std::int64_t local :
       {0xef53LL, 0x58465342LL, 0x9123683eLL, 0x2fc12fc1LL, 0x01021994LL, 0x794c7630LL, 0xca451a4eLL, 0xf2f52010LL})
    EXPECT_EQ(network_disk_name(local), "") << std::hex << local;
  testing::expect_error(ErrorCode::kEnvironment, {"/none", "file system"}, [] { check_is_local("/none"); });
}

}  // namespace
}  // namespace multum
