// SPDX-License-Identifier: Apache-2.0
// Tests Base64 with the examples of RFC 4648, section 10, and with every byte in both directions.
#include "host/foundation/base/base64.h"

#include <gtest/gtest.h>

#include <utility>

namespace multum {
namespace {

TEST(Base64, HasTheExamplesOfItsDefinition) {
  const std::pair<const char*, const char*> examples[] = {{"", ""},
                                                          {"f", "Zg=="},
                                                          {"fo", "Zm8="},
                                                          {"foo", "Zm9v"},
                                                          {"foob", "Zm9vYg=="},
                                                          {"fooba", "Zm9vYmE="},
                                                          {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : examples) {
    EXPECT_EQ(encode_base64(bytes), text);
    EXPECT_EQ(decode_base64(text), bytes);
  }
}

TEST(Base64, KeepsEveryByteAndRefusesOtherCharacters) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);
  EXPECT_EQ(decode_base64(encode_base64(bytes)), bytes);
  for (const char* text : {"Zm9v Zg", "Zm9-", "Zm9v\n", "\xff"}) EXPECT_FALSE(decode_base64(text)) << text;
}

}  // namespace
}  // namespace multum
