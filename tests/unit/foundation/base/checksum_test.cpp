// SPDX-License-Identifier: Apache-2.0
// Tests the checksum of scratch files: a known value, the same result for pieces as for the whole, and the detection of
// damage.
#include "host/foundation/base/files/checksum.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace multum {
namespace {

std::string checksum_of(const std::vector<std::string>& pieces) {
  Checksum checksum;
  for (const std::string& piece : pieces) checksum.update(piece.data(), piece.size());
  return checksum.text();
}

TEST(ChecksumTest, IsCrc64OfEcma182Reflected) {
  EXPECT_EQ(checksum_of({"123456789"}), "995dc9bbdf1939fa");  // the check value of CRC-64/XZ
}

TEST(ChecksumTest, PiecesCountAsTheWhole) {
  const std::string text(100000, 'm');
  EXPECT_EQ(checksum_of({text.substr(0, 1), text.substr(1, 4096), text.substr(4097)}), checksum_of({text}));
}

TEST(ChecksumTest, OneBitChangesIt) {
  std::string text(65536, 'm');
  const std::string before = checksum_of({text});
  text[40000] = static_cast<char>(text[40000] ^ 1);
  EXPECT_NE(checksum_of({text}), before);
}

}  // namespace
}  // namespace multum
