// SPDX-License-Identifier: Apache-2.0
// Tests that every file name can be written to JSON and read again byte by byte, and that no two names have the same
// text.
#include "host/foundation/base/path_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "host/foundation/base/split_mix.h"

namespace multum::testing {
namespace {

std::string through_json(const std::string& path) {
  const std::string json = nlohmann::json(text_of_path(path)).dump();  // throws if the text is not UTF-8
  return path_of_text(nlohmann::json::parse(json).get<std::string>());
}

TEST(PathTextTest, NamesOfUtf8AreTheirOwnText) {
  for (const char* name : {"", "/srv/maps/rock.png", "caf\xc3\xa9.png", "\xf0\x9f\xaa\xa8 rock.png", "a\\b \"c\".png",
                           "\xef\xbf\xbd.png", "\xee\x80\x80.png"}) {
    EXPECT_EQ(text_of_path(name), name);
    EXPECT_TRUE(is_own_text(name)) << name;
  }
}

TEST(PathTextTest, OtherNamesAreReversible) {
  EXPECT_EQ(text_of_path("caf\xe9.png"), "caf\uefe9.png");
  EXPECT_EQ(path_of_text("caf\uefe9.png"), "caf\xe9.png");
  // Overlong, a surrogate, beyond U+10FFFF, truncated, and bytes that begin no character.
  for (const char* name :
       {"caf\xe9.png", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "a\xe2\x82", "\x80\xff\xc3\xa9"}) {
    EXPECT_FALSE(is_own_text(name)) << name;
    EXPECT_EQ(through_json(name), name);
  }
}

TEST(PathTextTest, CharactersOfTheEscapeItselfCollideWithNothing) {
  const std::string own = "\uefe9.png";  // a valid name that looks like the escaped form of another name
  EXPECT_NE(text_of_path(own), text_of_path("\xe9.png"));
  EXPECT_EQ(through_json(own), own);
}

TEST(PathTextTest, AMessageMayQuoteTextsAlready) {
  EXPECT_EQ(text_of_message("caf\xe9.png: is not there"), "caf\uefe9.png: is not there");
  EXPECT_EQ(text_of_message("caf\uefe9.png: is not there"), "caf\uefe9.png: is not there");
  EXPECT_EQ(paths_of_texts(texts_of_paths({"a", "\xff", ""})), (std::vector<std::string>{"a", "\xff", ""}));
}

TEST(PathTextTest, RandomBytesComeBackAndCollideWithNothing) {
  SplitMix64 random(51);
  std::set<std::string> paths, texts;
  for (int i = 0; i < 20000; ++i) {
    std::string path;
    const std::uint64_t length = random.next() % 6;
    for (std::uint64_t j = 0; j < length; ++j) {
      // Uses bytes of multi-byte characters and of the escape, which random bytes would rarely form.
      constexpr unsigned char kOften[] = {0xee, 0xbe, 0xbf, 0x80, 0xa9, 0xc3, 'a'};
      const std::uint64_t one = random.next();
      const auto byte = one % 2 == 0 ? kOften[one / 2 % sizeof(kOften)] : static_cast<unsigned char>(1 + one / 2 % 255);
      path += static_cast<char>(byte);
    }
    ASSERT_EQ(through_json(path), path);
    paths.insert(path);
    texts.insert(text_of_path(path));
  }
  EXPECT_EQ(texts.size(), paths.size());
}

}  // namespace
}  // namespace multum::testing
