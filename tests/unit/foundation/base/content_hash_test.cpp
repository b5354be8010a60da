// SPDX-License-Identifier: Apache-2.0
// Tests SHA-256 with the examples of NIST for FIPS 180-4. Also passes texts in pieces of different sizes.
#include "host/foundation/base/files/content_hash.h"

#include <gtest/gtest.h>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

const std::string kAbc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
const std::string kMillionA = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";

TEST(ContentHashTest, KnownVectors) {
  EXPECT_EQ(hash_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash_text("abc"), kAbc);
  EXPECT_EQ(hash_text("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hash_text(std::string(1000000, 'a')), kMillionA);
}

TEST(ContentHashTest, PiecesEqualTheWhole) {
  ContentHash hash;
  hash.update("a");
  hash.update("");
  hash.update("bc");
  EXPECT_EQ(hash.finish(), kAbc);
}

TEST(ContentHashTest, FilesAndRefusals) {
  const testing::TemporaryFolder folder;
  testing::write_bytes(folder / "a", std::string(1000000, 'a'));
  EXPECT_EQ(hash_file(folder / "a"), kMillionA);
  testing::expect_error(ErrorCode::kInput, {folder / "none", "cannot be opened", "No such file"},
                        [&] { hash_file(folder / "none"); });
  testing::expect_error(ErrorCode::kInput, {folder.path(), "is a folder"}, [&] { hash_file(folder.path()); });
}

}  // namespace
}  // namespace multum
