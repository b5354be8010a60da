// SPDX-License-Identifier: Apache-2.0
// Tests documents that are just within or just beyond every limit, strings and comments that look like structure, and
// random documents. Every document that the scan accepts is parsed, walked and destroyed on a small stack. Such a
// document is no deeper and no larger than the limits allow.
#include "host/foundation/toml/toml_limits.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "host/foundation/base/processes/sanitizers.h"
#include "host/foundation/base/split_mix.h"
#include "host/foundation/toml/strict_toml.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

// Returns "a.a.a" with `parts` parts.
std::string dotted(std::size_t parts, const std::string& part = "a") { return part + repeated("." + part, parts - 1); }

// Runs `body` in a thread with a stack of 256 KiB, or of 4 MiB under sanitizers, which use larger frames.
void on_small_stack(std::function<void()> body) {
#ifdef MULTUM_SHADOW_MEMORY
  constexpr std::size_t kStackBytes = std::size_t{4} << 20;
#else
  constexpr std::size_t kStackBytes = std::size_t{256} << 10;
#endif
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, kStackBytes), 0);
  pthread_t thread;
  const auto run = [](void* given) -> void* {
    (*static_cast<std::function<void()>*>(given))();
    return nullptr;
  };
  ASSERT_EQ(pthread_create(&thread, &attributes, run, &body), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
}

struct TreeSize {
  int depth = 0;  // of nested tables and arrays
  std::size_t nodes = 0;
};

void measure(const toml::node& node, int depth, TreeSize& size) {
  ++size.nodes;
  size.depth = std::max(size.depth, depth);
  if (const auto* table = node.as_table())
    for (const auto& [key, value] : *table) measure(value, depth + 1, size);
  if (const auto* array = node.as_array())
    for (const toml::node& value : *array) measure(value, depth + 1, size);
}

class TomlLimitsTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_ / "file.toml"; }
  toml::table parse(const std::string& text, const TomlLimits& limits = {}) const {
    write_bytes(path(), text);
    return parse_toml(path(), "a file", limits);
  }
  void expect_refused(const std::string& text, int line, const std::vector<std::string>& parts,
                      const TomlLimits& limits = {}) const {
    std::vector<std::string> all = {path() + ":" + std::to_string(line) + ": ", "expected at most"};
    all.insert(all.end(), parts.begin(), parts.end());
    expect_error(ErrorCode::kInput, all, [&] { parse(text, limits); });
  }

  TemporaryFolder folder_;
};

// ---- Each limit: the largest number that is accepted, and one more

struct LimitCase {
  std::string name;
  std::size_t most;                              // largest allowed `count`
  std::function<std::string(std::size_t)> text;  // the last line of the document exceeds the limit
  std::string number;                            // in the message
};

std::vector<LimitCase> limit_cases() {
  return {
      {"parts of a key", 32, [](std::size_t n) { return dotted(n) + " = 1"; }, "32"},
      {"quoted parts", 32, [](std::size_t n) { return dotted(n, "\"a.b\"") + " = 1"; }, "32"},
      {"literal parts", 32, [](std::size_t n) { return "b = 1\n" + dotted(n, "'a]'") + " = 1"; }, "32"},
      {"parts apart", 32, [](std::size_t n) { return "a" + repeated(" \t. a", n - 1) + " = 1"; }, "32"},
      {"parts of a header", 32, [](std::size_t n) { return "b = 1\n[" + dotted(n) + "]"; }, "32"},
      {"parts of an array's header", 32, [](std::size_t n) { return "[[" + dotted(n) + "]]"; }, "32"},
      {"header and key", 22, [](std::size_t n) { return "[" + dotted(10) + "]\n" + dotted(n) + " = 1"; }, "32"},
      {"arrays", 31, [](std::size_t n) { return "a = " + repeated("[", n) + repeated("]", n); }, "32"},
      {"arrays apart", 31, [](std::size_t n) { return "a =" + repeated("[ ", n) + repeated("]", n); }, "32"},
      {"inline tables", 15, [](std::size_t n) { return "a = " + repeated("{a = ", n) + "1" + repeated("}", n); }, "32"},
      {"tables in arrays", 10, [](std::size_t n) { return "a=" + repeated("[{a=", n) + "1" + repeated("}]", n); },
       "32"},
      {"dotted keys in tables", 10, [](std::size_t n) { return "a=" + repeated("{a.a=", n) + "1" + repeated("}", n); },
       "32"},
      {"the second table", 30, [](std::size_t n) { return "a = [{a = [1]}, {" + dotted(n - 1) + " = 1}]"; }, "32"},
      {"values of an array", 199'998, [](std::size_t n) { return "a = [" + repeated("1,", n) + "]"; }, "200000"},
      {"texts of an array", 199'998, [](std::size_t n) { return "a = [" + repeated("'a,b',", n) + "]"; }, "200000"},
      {"empty arrays", 199'998, [](std::size_t n) { return "a = [" + repeated("[],", n) + "]"; }, "200000"},
      {"dots", 10'000,
       [](std::size_t n) {
         std::string text;
         for (std::size_t i = 0; i < n; ++i) text += (i > 0 ? "\na.b" : "a.b") + std::to_string(i) + " = 1";
         return text;
       },
       "10000"},
      {"keys", 100'000,
       [](std::size_t n) {
         std::string text;
         for (std::size_t i = 0; i < n; ++i) text += (i > 0 ? "\nk" : "k") + std::to_string(i) + " = 1";
         return text;
       },
       "200000"},
      {"names of arrays of tables", 1'000,
       [](std::size_t n) {
         std::string text;
         for (std::size_t i = 0; i < n; ++i) text += (i > 0 ? "\n[[t" : "[[t") + std::to_string(i) + "]]";
         return text;
       },
       "1000"},
      {"tables of an array", 99'998,
       [](std::size_t n) { return "c = 1\n" + repeated("[[a]]\n", n - 1) + "[[a]]\nb = 1"; }, "200000"},
  };
}

TEST_F(TomlLimitsTest, TheLargestIsReadAndOneMoreIsRefused) {
  for (const LimitCase& one : limit_cases()) {
    SCOPED_TRACE(one.name);
    on_small_stack([&] { EXPECT_NO_THROW(parse(one.text(one.most))); });
    const std::string beyond = one.text(one.most + 1);
    const auto lines = 1 + std::count(beyond.begin(), beyond.end(), '\n');
    expect_refused(beyond, static_cast<int>(lines), {one.number});
  }
}

TEST_F(TomlLimitsTest, TheDeepestArraysOfTablesAreReadOnASmallStack) {
  std::string text;
  for (std::size_t parts = 1; parts <= 32; ++parts) text += "[[" + dotted(parts) + "]]\n";
  on_small_stack([&] {
    TreeSize size;
    measure(parse(text), 0, size);
    EXPECT_EQ(size.depth, 64);
  });
}

// Tests documents that once crashed programs or took a gigabyte.
TEST_F(TomlLimitsTest, AreHeldFarBeyondThemToo) {
  expect_refused("b = 1\n" + dotted(32'000) + " = 1\n", 2, {"dotted key", "32"});
  expect_refused("[" + dotted(500'000) + "]\n", 1, {"32"});
  expect_refused("a = " + repeated("[", 1'000'000), 1, {"32"});
  expect_refused("a = [" + repeated("1,", 1'500'000) + "]", 1, {"200000"});
}

TEST_F(TomlLimitsTest, BytesAreCountedBeforeTheyAreRead) {
  const TomlLimits limits;
  EXPECT_NO_THROW(parse("a = 1 #" + std::string(limits.byte_max - 7, '.')));
  const std::vector<std::string> parts = {"4194304", "bytes"};
  expect_error(ErrorCode::kInput, parts, [&] { parse(std::string(limits.byte_max + 1, '\n')); });
  std::filesystem::remove(path());
  write_bytes(path(), "");
  std::filesystem::resize_file(path(), std::uintmax_t{1} << 40);  // with a hole of a terabyte
  expect_error(ErrorCode::kInput, {path(), "4194304"}, [&] { parse_toml(path(), "a file"); });
  expect_error(ErrorCode::kInput, {folder_.path(), "a folder"}, [&] { parse_toml(folder_.path(), "a file"); });
  expect_error(ErrorCode::kInput, {"none.toml", "read"}, [&] { parse_toml(folder_ / "none.toml", "a file"); });
}

// ---- Strings and comments

// Outside strings, these characters would all count as structure. Quotes, backslashes and line breaks are left out.
std::string structure() { return repeated("a.b.[{[[x]]=,1,}]#", 20'000); }

struct HidingCase {
  std::string name, text;  // a document with complete lines that set a key a
  std::string value;       // the expected value of a; it is not checked if empty
};

std::vector<HidingCase> hiding_cases() {
  const std::string s = structure();
  const std::string lines = s + "\n" + s;
  return {
      {"comment", "a = 'x' # " + s + "\"'\n", "x"},
      {"comment of a line", "# " + s + "\"\"\"\na = 'x'\n", "x"},
      {"comment in an array", "a = [ # " + s + "]'''\n 1]\n", ""},
      {"basic string", "a = \"" + s + "'\"\n", s + "'"},
      {"escaped quotes", "a = \"\\\"" + s + "\\\\\"\n", "\"" + s + "\\"},
      {"literal string", "a = '" + s + "\"\\'\n", s + "\"\\"},
      {"multi-line string", "a = \"\"\"\n" + lines + "\"\" ' \\\" \"\"\"\n", lines + "\"\" ' \" "},
      {"multi-line string that ends in quotes", "a = \"\"\"" + lines + "\"\"\"\"\"\n", lines + "\"\""},
      {"multi-line string with an escaped quote at its end", "a = \"\"\"" + lines + "\\\"\"\"\"\n", lines + "\""},
      {"multi-line literal", "a = '''\n" + lines + "\\\"\"\" '' '''\n", lines + "\\\"\"\" '' "},
      {"multi-line literal that ends in a quote", "a = '''" + lines + "''''\n", lines + "'"},
      {"empty strings", "b = \"\"\nc = ''\nd = [\"\", '', \"\"\"\"\"\", '''''']\na = 'x' # " + s + "\n", "x"},
      {"quoted key", "\"" + s + "\" = 1\na = 'x'\n", "x"},
      {"literal key", "'" + s + "' = 1\na = 'x'\n", "x"},
      {"quoted header", "a = 'x'\n['" + s + "']\n[\"" + s + "y\"]\n", "x"},
      {"inline table", "a = 'x'\nb = {c = \"" + s + "\", '" + s + "' = 1}\n", "x"},
      {"numbers", "a = 'x'\nb = [" + repeated("1.5e-3, -0.25, 1979-05-27T07:32:00.5Z, ", 30'000) + "]\n", "x"},
      {"byte order mark", "\xef\xbb\xbf[t]\nb = 1\n[[u]]\n# " + s + "\n", ""},
      {"ends of lines as elsewhere", "a = 'x' # " + s + "\r\nb = \"\"\"\r\n" + s + "\r\n\"\"\"\r\n", "x"},
  };
}

TEST_F(TomlLimitsTest, StringsAndCommentsDoNotCount) {
  for (const HidingCase& one : hiding_cases()) {
    SCOPED_TRACE(one.name);
    try {
      const toml::table table = parse(one.text);
      EXPECT_TRUE(one.value.empty() || table["a"].value<std::string>() == one.value);
    } catch (const Error& error) {
      ADD_FAILURE() << std::string(error.what()).substr(0, 300);
    }
  }
}

TEST_F(TomlLimitsTest, WhatFollowsThemDoesAndItsLineIsKnown) {
  for (const HidingCase& one : hiding_cases()) {
    SCOPED_TRACE(one.name);
    const auto line = 1 + static_cast<int>(std::count(one.text.begin(), one.text.end(), '\n'));
    expect_refused(one.text + "z = " + repeated("[", 40), line, {"32"});
    expect_refused(one.text + dotted(40) + " = 1", line, {"32"});
  }
}

TEST_F(TomlLimitsTest, RefusalsOfTheParserStayShort) {
  const std::string text = "[[map]]\n" + std::string(1'000'000, 'k') + " = 1\n";
  try {
    const toml::table root = parse(text);
    const StrictTable strict(path(), *root["map"].as_array()->get(0)->as_table(), "map", {"input", "output"});
    ADD_FAILURE() << "an unknown key was accepted";
  } catch (const Error& error) {
    EXPECT_LT(std::string(error.what()).size(), 2'000u);
  }
}

// ---- Random documents

class RandomDocument {
 public:
  explicit RandomDocument(std::uint64_t seed) : random_(seed) {}

  // Joins tokens of TOML in any order; most results are invalid.
  std::string pieces() {
    static const std::vector<std::string> kPieces = {"a",
                                                     "b",
                                                     "c.d",
                                                     ".",
                                                     "=",
                                                     " = ",
                                                     "[",
                                                     "[[",
                                                     "]",
                                                     "]]",
                                                     "{",
                                                     "}",
                                                     ",",
                                                     "\n",
                                                     "\n",
                                                     "#",
                                                     "\"",
                                                     "'",
                                                     "\"\"",
                                                     "''",
                                                     "\"\"\"",
                                                     "'''",
                                                     "\\",
                                                     "\\\"",
                                                     "1",
                                                     "-2.5",
                                                     "true",
                                                     " ",
                                                     "\t",
                                                     "\r\n",
                                                     "\"x\"",
                                                     "'y'",
                                                     "\"\"\"\n",
                                                     "a = 1\n",
                                                     "[t]\n",
                                                     "[[u.v]]\n",
                                                     "\xc2\x85",
                                                     "\xe2\x80\xa8",
                                                     "\v",
                                                     "\f",
                                                     "1979-05-27 07:32:00",
                                                     "{a.b = 1}",
                                                     "a = [",
                                                     "= {"};
    std::string text;
    for (std::size_t left = below(60); left > 0; --left) text += kPieces[below(kPieces.size())];
    return text;
  }

  // Makes mostly valid TOML; keys may appear twice.
  std::string document() {
    std::string text;
    for (std::size_t left = below(8); left > 0; --left) {
      const bool is_array = below(2) == 0;
      if (below(3) == 0) text += (is_array ? "[[" : "[") + key() + (is_array ? "]]" : "]") + rest_of_line();
      else text += key() + " = " + value(static_cast<int>(below(7))) + rest_of_line();
    }
    return text;
  }

 private:
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_.next() % count); }
  std::string name() {
    const std::string letter(1, static_cast<char>('a' + below(12)));
    switch (below(5)) {
      case 0: return "\"" + letter + ".=[\\\"\"";
      case 1: return "'" + letter + "\\#]'";
      default: return letter;
    }
  }
  std::string key() {
    std::string text = name();
    for (std::size_t left = below(3) == 0 ? below(4) : 0; left > 0; --left)
      text += (below(2) == 0 ? "." : " . ") + name();
    return text;
  }
  std::string rest_of_line() { return below(4) == 0 ? " # [{\"'''a.b\n" : below(2) == 0 ? "\n" : "\r\n\n"; }
  std::string value(int depth) {
    static const std::vector<std::string> kValues = {"1",
                                                     "-2.5e3",
                                                     "true",
                                                     "1979-05-27",
                                                     "1979-05-27 07:32:00.5",
                                                     "\"[a.b]\"",
                                                     "'{,=#'",
                                                     "\"\"\"\n]\"\"\"\"",
                                                     "'''''a\n'b''''",
                                                     "\"\"",
                                                     "\"\\\\\"",
                                                     "''"};
    if (depth == 0) return kValues[below(kValues.size())];
    std::string text;
    if (below(2) == 0) {
      for (std::size_t left = below(4); left > 0; --left)
        text += value(depth - 1) + (below(3) == 0 ? " # ]\n," : left > 1 ? ", " : "");
      return "[" + text + "]";
    }
    for (std::size_t left = below(4); left > 0; --left) text += key() + "=" + value(depth - 1) + (left > 1 ? "," : "");
    return "{" + text + "}";
  }

  SplitMix64 random_;
};

TEST_F(TomlLimitsTest, WhatIsAcceptedIsNoDeeperAndNoLarger) {
  constexpr std::uint64_t kSeed = 20261;
  TomlLimits narrow;
  narrow.depth_max = 6;
  narrow.key_part_max = 3;
  narrow.item_max = 30;
  std::size_t read = 0, limited = 0, deep = 0;
  on_small_stack([&] {
    for (std::uint64_t i = 0; i < 20'000; ++i) {
      RandomDocument random(kSeed + i);
      const std::string text = i % 2 == 0 ? random.document() : random.pieces();
      SCOPED_TRACE(text + "\nseed " + std::to_string(kSeed + i));
      bool is_within = true;
      try {
        check_toml_limits(path(), text, narrow);
      } catch (const Error&) {
        is_within = false;
      }
      TreeSize size;
      try {
        measure(toml::parse(text), 0, size);
      } catch (const toml::parse_error&) {
        continue;
      }
      ++read;
      limited += is_within ? 0 : 1;
      deep += size.depth > 2 * narrow.depth_max || size.nodes > narrow.item_max + 1 ? 1 : 0;
      // An array of tables is a level of its own in addition to each part of its name.
      if (is_within) {
        EXPECT_LE(size.depth, 2 * narrow.depth_max);
        EXPECT_LE(size.nodes, narrow.item_max + 1);  // plus one for the document itself
      }
    }
  });
  // The number of accepted documents must be large enough to test both outcomes.
  EXPECT_GT(read, 3'000u);
  EXPECT_GT(limited, 100u);
  EXPECT_GT(deep, 10u);
}

TEST_F(TomlLimitsTest, WhatIsAcceptedIsReadOnASmallStack) {
  constexpr std::uint64_t kSeed = 20262;
  on_small_stack([&] {
    for (std::uint64_t i = 0; i < 300; ++i) {
      SplitMix64 random(kSeed + i);
      // The document is as deep as allowed, and alternates all kinds of nesting.
      std::string text, end;
      int left = 31;
      while (left > 0) {
        const auto kind = random.next() % 3;
        const int parts = std::min<int>(left - 1, 1 + static_cast<int>(random.next() % 4));
        if (kind == 0 || parts < 1) {
          text += "[";
          end = "]" + end;
          --left;
        } else {
          text += "{" + dotted(static_cast<std::size_t>(parts)) + "=";
          end = "}" + end;
          left -= 1 + parts;
        }
      }
      const std::string whole = "a = " + text + "1" + end;
      EXPECT_NO_THROW(parse(whole)) << whole;
      expect_error(ErrorCode::kInput, {"32"}, [&] { parse("a = " + text + "[1]" + end); });
    }
  });
}

}  // namespace
}  // namespace multum::testing
