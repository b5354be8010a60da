// SPDX-License-Identifier: Apache-2.0
// Tests that control sequences for terminals are made visible, and that all other text stays unchanged.
#include "host/foundation/base/shown_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "host/foundation/base/split_mix.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

std::string utf8(unsigned code) {
  const auto byte = [](unsigned value) { return static_cast<char>(value); };
  if (code < 0x80) return {byte(code)};
  if (code < 0x800) return {byte(0xc0 | code >> 6), byte(0x80 | (code & 63))};
  if (code < 0x10000) return {byte(0xe0 | code >> 12), byte(0x80 | (code >> 6 & 63)), byte(0x80 | (code & 63))};
  return {byte(0xf0 | code >> 18), byte(0x80 | (code >> 12 & 63)), byte(0x80 | (code >> 6 & 63)),
          byte(0x80 | (code & 63))};
}

bool is_control(unsigned code) {
  return (code < 0x20 && code != '\t' && code != '\n') || (code >= 0x7f && code < 0xa0);
}

TEST(ShownTextTest, EveryControlCharacterIsShownAndNoOtherCharacter) {
  for (unsigned code = 0; code < 0x11'0000; ++code) {
    if (code >= 0xd800 && code < 0xe000) continue;  // surrogates are not characters
    const std::string text = "a" + utf8(code) + "b";
    if (is_control(code)) {
      EXPECT_TRUE(std::regex_match(shown_text(text), std::regex(R"(a(\\x[0-9a-f][0-9a-f]){1,2}b)"))) << code;
    } else {
      ASSERT_EQ(shown_text(text), text) << code;
    }
  }
  EXPECT_EQ(shown_text("\x1b[31m\r\x7f"), "\\x1b[31m\\x0d\\x7f");
  EXPECT_EQ(shown_text("q\xc2\x9b"
                       "31m"),
            "q\\xc2\\x9b31m");
}

TEST(ShownTextTest, BytesThatAreNoUtf8AreShown) {
  EXPECT_EQ(shown_text("q\x9b"
                       "31m"),
            "q\\x9b31m");                                  // a one-byte C1 character
  EXPECT_EQ(shown_text("\xc3"), "\\xc3");                  // cut
  EXPECT_EQ(shown_text("\xc3\x9b\x9b"), "\xc3\x9b\\x9b");  // a letter, then C1
  EXPECT_EQ(shown_text("\xe2\x82"
                       "a"),
            "\\xe2\\x82"
            "a");                                                     // cut within
  EXPECT_EQ(shown_text("\xc1\x9b"), "\\xc1\\x9b");                    // over-long
  EXPECT_EQ(shown_text("\xe0\x82\x9b"), "\\xe0\\x82\\x9b");           // U+009B, over-long
  EXPECT_EQ(shown_text("\xf0\x80\x82\x9b"), "\\xf0\\x80\\x82\\x9b");  // the same
  EXPECT_EQ(shown_text("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(shown_text("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond U+10FFFF
  EXPECT_EQ(shown_text(std::string("\0\xff", 2)), "\\x00\\xff");
}

TEST(ShownTextTest, AnyBytesBecomeTextWithoutControls) {
  SplitMix64 random(20264);
  static const std::string kPieces[] = {"\x1b", "\xc2", "\x9b", "\xe2\x80", "\xa8", "a", "\xf0\x9f\x98\x80",
                                        "\xed", "\n"};
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (auto left = random.next() % 12; left > 0; --left)
      text += random.next() % 2 == 0 ? kPieces[random.next() % std::size(kPieces)]
                                     : std::string(1, static_cast<char>(random.next()));
    const std::string shown = shown_text(text);
    // Decodes with nlohmann's library, which throws if the text is not UTF-8.
    ASSERT_NO_THROW(nlohmann::json(shown).dump()) << i;
    for (std::size_t at = 0; at < shown.size(); ++at) {
      const auto byte = static_cast<unsigned char>(shown[at]);
      ASSERT_TRUE(byte >= 0x80 || !is_control(byte)) << i;
      ASSERT_TRUE(byte != 0xc2 || static_cast<unsigned char>(shown.at(at + 1)) >= 0xa0) << i;
    }
  }
}

TEST(ShownTextTest, FilesGetTheBytesAsTheyAre) {
  const TemporaryFolder folder;
  const std::string text("\x1b[31m\xc2\x9b\x9b\0z\n", 12);
  std::FILE* const file = std::fopen((folder / "a").c_str(), "w");
  ASSERT_NE(file, nullptr);
  write_shown(file, text);
  print_shown(file, "%s %d %5.2f\n", "\x9b", 7, 1.5);
  print_shown(file, "%s", "");
  std::fclose(file);
  EXPECT_EQ(read_bytes(folder / "a"), text + "\x9b 7  1.50\n");
}

TEST(ShownTextTest, JsonStaysTheSameJson) {
  for (unsigned code = 0; code < 0x800; ++code) {
    const nlohmann::json json = {{"a" + utf8(code), utf8(code) + utf8(code)}};
    const std::string escaped = escaped_json(json.dump());
    EXPECT_EQ(nlohmann::json::parse(escaped), json) << code;
    EXPECT_EQ(shown_text(escaped), escaped) << code;
  }
}

TEST(ShownTextTest, CharactersAreNotCut) {
  for (const std::string& character : {utf8('a'), utf8(0xe9), utf8(0x20ac), utf8(0x1f600)}) {
    const std::string text = "ab" + character;
    EXPECT_EQ(whole_characters(text), text.size());
    for (std::size_t cut = 1; cut < character.size(); ++cut)
      EXPECT_EQ(whole_characters(text.substr(0, text.size() - cut)), 2u);
  }
  EXPECT_EQ(whole_characters(""), 0u);
  EXPECT_EQ(whole_characters("a\x9b\x9b\x9b\x9b"), 5u) << "bytes of no character are not waited for";
}

TEST(ShownTextTest, Utf8AndControlCharactersAreKnown) {
  for (const std::string& text : {std::string(), std::string("a\n"), utf8(0xe9), utf8(0x20ac) + "b", utf8(0x10ffff)})
    EXPECT_TRUE(is_utf8(text)) << text;
  for (const char* text : {"\xff", "a\xc3", "\xc0\xaf", "\xed\xa0\x80", "\xc3\xa9\x80"})
    EXPECT_FALSE(is_utf8(text)) << text;
  for (const char* text : {"\n", "a\t", "\x1b", "\x7f", "a\xc2\x85", "\xff\r"})
    EXPECT_TRUE(holds_control(text)) << text;
  for (const char* text : {"", "a b", "\x9b", "\xc2\xa0", "\xc3\x85"}) EXPECT_FALSE(holds_control(text)) << text;
}

}  // namespace
}  // namespace multum::testing
