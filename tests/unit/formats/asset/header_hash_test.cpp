// SPDX-License-Identifier: Apache-2.0
// Tests headers with changed bytes in every kind of file. If OpenEXR reads different values, verify must reject the
// file.
#include "host/formats/asset/header_hash.h"

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <tuple>

#include "host/foundation/base/split_mix.h"
#include "tests/fixtures/small_baked_files.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

// Describes where in the file's bytes an attribute of a part is.
struct AttributePlace {
  int part;
  std::string name;
  std::size_t begin, value_begin, end;
};

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 4; i > 0; --i) number = number << 8 | static_cast<unsigned char>(bytes[at + i - 1]);
  return number;
}

std::vector<AttributePlace> attribute_places(const std::string& bytes) {
  const bool is_multi_part = (number_at(bytes, 4) & 0x1000) != 0;
  std::vector<AttributePlace> places;
  std::size_t at = 8;
  for (int part = 0; bytes[at] != 0; ++part) {
    while (bytes[at] != 0) {
      const std::string name = bytes.c_str() + at;
      const std::size_t type_at = at + name.size() + 1, size_at = type_at + std::strlen(bytes.c_str() + type_at) + 1;
      places.push_back({part, name, at, size_at + 4, size_at + 4 + number_at(bytes, size_at)});
      at = places.back().end;
    }
    ++at;
    if (!is_multi_part) break;
  }
  return places;
}

AttributePlace place_of(const std::string& bytes, const std::string& name) {
  for (const AttributePlace& place : attribute_places(bytes))
    if (place.name == name) return place;
  ADD_FAILURE() << "no attribute " << name;
  return {};
}

using Values = std::map<std::tuple<int, std::string, std::string>, std::string>;  // indexed by part, name and type

// Returns the values that OpenEXR reads, encoded as OpenEXR would write them. Compression is not a value of the file.
Values values_read(const std::string& path) {
  Imf::MultiPartInputFile file(path.c_str(), 1);
  Values values;
  for (int part = 0; part < file.parts(); ++part)
    for (auto at = file.header(part).begin(); at != file.header(part).end(); ++at) {
      if (std::string(at.name()) == "compression") continue;
      Imf::StdOSStream text;
      at.attribute().writeValueTo(text, 2);
      values[{part, at.name(), at.attribute().typeName()}] = text.str();
    }
  return values;
}

// Returns the failed checks of a file with these `bytes`, or "refused" if the file cannot be read.
std::set<std::string> failed_checks(const std::string& path, const std::string& bytes) {
  write_bytes(path, bytes);
  std::set<std::string> failed;
  try {
    for (const VerifyFinding& finding : verify_baked(path, 1))
      if (!finding.passed) failed.insert(finding.check);
  } catch (const Error&) {
    failed.insert("refused");
  }
  return failed;
}

std::string header_detail(const std::string& path) {
  for (const VerifyFinding& finding : verify_baked(path, 1))
    if (finding.check == "header") return finding.detail;
  return "no check of the header";
}

struct Kind {
  std::string name;
  std::function<void(const std::string& path)> write;
};

std::vector<Kind> kinds() {
  return {
      {"movmf", [](const std::string& path) { write_small_lobes(path, Representation::kMovmf, "none"); }},
      {"gmm", [](const std::string& path) { write_small_lobes(path, Representation::kGmm, "zip:1"); }},
      {"moments", write_small_moments},
      {"sh", write_small_harmonics},
      {"pyramid", write_small_pyramid},
  };
}

class HeaderHashTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_ / "a.ndf.exr"; }
  TemporaryFolder folder_;
};

// Half of the mutants change a byte of an attribute's value. A quarter change any byte of the headers, and a quarter
// change a byte of an attribute's name, type or size.
std::string mutant(const std::string& whole, const std::vector<AttributePlace>& places, SplitMix64& random) {
  const auto below = [&](std::size_t count) { return static_cast<std::size_t>(random.next() % count); };
  const AttributePlace& place = places[below(places.size())];
  const std::size_t kind = below(4), value_size = place.end - place.value_begin;
  std::size_t at = below(places.back().end);
  if (kind < 2 && value_size > 0) at = place.value_begin + below(std::min<std::size_t>(value_size, 100));
  if (kind == 2) at = place.begin + below(place.value_begin - place.begin);
  std::string changed = whole;
  changed[at] = static_cast<char>(below(2) == 0 ? changed[at] ^ (1 << below(8)) : changed[at] + 1 + below(255));
  return changed;
}

TEST_F(HeaderHashTest, NoMutantWithOtherValuesIsAccepted) {
  constexpr std::uint64_t kSeed = 20263;
  constexpr int kMutants = 400;
  for (const Kind& kind : kinds()) {
    kind.write(path());
    const std::string whole = read_bytes(path());
    const std::vector<AttributePlace> places = attribute_places(whole);
    ASSERT_EQ(failed_checks(path(), whole), std::set<std::string>()) << kind.name;
    const Values values = values_read(path());
    SplitMix64 random(kSeed);
    int by_header_alone = 0, unchanged = 0;
    for (int i = 0; i < kMutants; ++i) {
      const std::string changed = mutant(whole, places, random);
      const std::set<std::string> failed = failed_checks(path(), changed);
      by_header_alone += failed == std::set<std::string>{"header"} ? 1 : 0;
      if (!failed.empty()) continue;
      ++unchanged;
      const Values found = values_read(path());
      EXPECT_TRUE(found == values) << kind.name << ", mutant " << i << " of seed " << kSeed << " is accepted";
    }
    // Only the checksum of the headers rejects these files. There are only few bytes without meaning.
    EXPECT_GT(by_header_alone, kMutants / 4) << kind.name;
    EXPECT_LT(unchanged, kMutants / 10) << kind.name;
    RecordProperty(kind.name + "_found_by_header_alone", by_header_alone);
    RecordProperty(kind.name + "_accepted_with_the_same_values", unchanged);
  }
}

// Changes the lowest bit of one value of every attribute of every part.
TEST_F(HeaderHashTest, EveryAttributeIsCoveredAndNamed) {
  for (const Kind& kind : kinds()) {
    kind.write(path());
    const std::string whole = read_bytes(path());
    for (const AttributePlace& place : attribute_places(whole)) {
      if (place.name == "compression" || place.value_begin == place.end) continue;
      SCOPED_TRACE(kind.name + ", " + place.name + " of part " + std::to_string(place.part));
      std::string changed = whole;
      changed[place.value_begin] = static_cast<char>(changed[place.value_begin] ^ 1);
      write_bytes(path(), changed);
      const VerifyFinding finding = header_finding(path());
      EXPECT_FALSE(finding.passed);
      EXPECT_NE(finding.detail.find(place.name), std::string::npos) << finding.detail;
    }
  }
}

TEST_F(HeaderHashTest, TheSharpestKappaTheSourceAndTheErrorsAreHeld) {
  write_small_lobes(path(), Representation::kMovmf, "none", "[[0,\"centre\",\"lambert\",0.125]]");
  const std::string whole = read_bytes(path());
  const auto change = [&](const std::string& name, const std::function<void(char* value)>& edit) {
    std::string changed = whole;
    edit(changed.data() + place_of(whole, name).value_begin);
    EXPECT_NE(changed, whole);
    EXPECT_EQ(failed_checks(path(), changed), (std::set<std::string>{"header"})) << name;
    EXPECT_NE(header_detail(path()).find(name + ";"), std::string::npos) << header_detail(path());
  };
  change("multum:kappaMax", [](char* value) {
    float kappa = 0.0f;
    std::memcpy(&kappa, value, sizeof(kappa));
    EXPECT_EQ(kappa, 20000.0f);
    kappa = 200.0f;
    std::memcpy(value, &kappa, sizeof(kappa));
  });
  change("multum:sourceHash", [](char* value) { std::fill_n(value, 64, 'c'); });
  change("multum:measuredError", [](char* value) { *std::strchr(value, '1') = '0'; });
  change("multum:settings", [](char* value) { *std::strchr(value, '2') = '3'; });
  change("software", [](char* value) { value[0] = 'M'; });
}

TEST_F(HeaderHashTest, AnyOtherCompressionIsTheSameFile) {
  write_small_lobes(path(), Representation::kMovmf, "zip:1");
  const std::string zip = header_detail(path());
  write_small_lobes(path(), Representation::kMovmf, "piz");
  EXPECT_EQ(header_detail(path()), zip);
}

TEST_F(HeaderHashTest, ADamagedChecksumIsNotThatOfAnEarlierVersion) {
  write_small_moments(path());
  const std::string whole = read_bytes(path());
  const AttributePlace place = place_of(whole, kHeaderHashAttribute);
  for (std::size_t at = place.begin; at < place.value_begin; ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_FALSE(failed_checks(path(), changed).empty()) << "byte " << at - place.begin;
  }
  for (const std::size_t offset : {0, 63, 64, 70, 2000}) {
    std::string changed = whole;
    changed[place.value_begin + offset] = '!';
    EXPECT_EQ(failed_checks(path(), changed), (std::set<std::string>{"header"})) << "byte " << offset;
  }
}

TEST_F(HeaderHashTest, FilesOfEarlierVersionsPassAndSaySo) {
  for (const Kind& kind : kinds()) {
    kind.write(path());
    std::string bytes = read_bytes(path());
    const AttributePlace place = place_of(bytes, kHeaderHashAttribute);
    // No reader knows a renamed attribute, so the attribute has no effect.
    bytes.replace(place.begin, 6, "others");
    bytes.replace(place.value_begin, place.end - place.value_begin, place.end - place.value_begin, ' ');
    EXPECT_EQ(failed_checks(path(), bytes), std::set<std::string>()) << kind.name;
    EXPECT_NE(header_detail(path()).find("older programs"), std::string::npos);
  }
}

}  // namespace
}  // namespace multum::testing
