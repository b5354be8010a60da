// SPDX-License-Identifier: Apache-2.0
// Tests that each file is hashed only once, and that a file never gets the hash of other bytes.
#include "host/foundation/base/files/input_hashes.h"

#include <gtest/gtest.h>

#include "host/foundation/base/files/content_hash.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

class InputHashesTest : public ::testing::Test {
 protected:
  std::string file(const std::string& bytes) {
    testing::write_bytes(folder_ / "a", bytes);
    return folder_ / "a";
  }
  void expect_changed(const std::function<void()>& call) const {
    testing::expect_error(ErrorCode::kInput, {folder_ / "a", "changed while it was being read"}, call);
  }

  const testing::TemporaryFolder folder_;
  InputHashes hashes_;
};

TEST_F(InputHashesTest, AFileIsReadOnce) {
  const std::string path = file("abc");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(hashes_.hash(path), hash_text("abc"));
  EXPECT_EQ(hashes_.read_count(), 1);
  hashes_.check_unchanged(path);
}

// The file must still be as it was when note() was called, because its bytes may have been decoded already.
TEST_F(InputHashesTest, AFileThatChangesBeforeItsHashIsRefused) {
  const std::string path = file("abc");
  hashes_.note(path);
  file("abd");  // same size, and within the same clock tick if possible
  expect_changed([&] { hashes_.check_unchanged(path); });
  expect_changed([&] { hashes_.hash(path); });
}

TEST_F(InputHashesTest, AFileThatChangesAfterItsHashIsRefusedToReaders) {
  const std::string path = file("abc");
  EXPECT_EQ(hashes_.hash(path), hash_text("abc"));
  testing::write_bytes(folder_ / "b", "abd");
  std::filesystem::rename(folder_ / "b", path);
  expect_changed([&] { hashes_.check_unchanged(path); });
  std::filesystem::remove(path);
  expect_changed([&] { hashes_.check_unchanged(path); });
}

// If somebody has set back the modification time, an unchanged time does not prove that the file is unchanged.
TEST_F(InputHashesTest, TheTimeOfAWriteCannotBeHidden) {
  const std::string path = file("abc");
  const auto before = std::filesystem::last_write_time(path);
  hashes_.note(path);
  file("xyz");
  std::filesystem::last_write_time(path, before);
  expect_changed([&] { hashes_.check_unchanged(path); });
}

TEST_F(InputHashesTest, WhatCannotBeReadIsToldByItsHash) {
  const std::string path = folder_ / "a";
  hashes_.note(path);
  hashes_.check_unchanged(path);
  testing::expect_error(ErrorCode::kInput, {path, "cannot be opened", "No such file"}, [&] { hashes_.hash(path); });
  EXPECT_EQ(hashes_.hash(file("abc")), hash_text("abc")) << "a new file is hashed once it exists";
  testing::expect_error(ErrorCode::kInput, {folder_.path(), "is a folder"}, [&] { hashes_.hash(folder_.path()); });
}

}  // namespace
}  // namespace multum
