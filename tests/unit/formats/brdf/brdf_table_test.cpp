// SPDX-License-Identifier: Apache-2.0
// Tests the table of BRDFs. Each row must have the properties that it states, and its texts must be read, refused and
// printed correctly.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <regex>

#include "host/formats/brdf/brdf_text.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/foundation/base/error.h"
#include "host/foundation/brdf_families/brdf_forms.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

Brdf parsed(const std::string& text) { return parse_brdf("--brdf", text, 4); }

// Returns texts that name BRDFs of a family: only the name if the family has no width, otherwise the name with widths
// at both ends of the range and between them.
std::vector<std::string> texts_of(const BrdfFamily& family) {
  if (family.is_file) return {};
  if (!family.has_width()) return {std::string(family.name)};
  const BrdfMember& width = family.members[0];
  std::vector<std::string> texts;
  for (const double value : {width.low, std::sqrt(width.low * width.high), width.high})
    texts.push_back(fmt::format("{}:{:.7g}", family.name, value));
  return texts;
}

TEST(BrdfTable, EveryRowIsReadAndPrinted) {
  for (const BrdfFamily& family : brdf_families()) {
    EXPECT_EQ(&brdf_family(family.kind), &family);
    EXPECT_EQ(find_brdf_family(family.name), &family);
    for (const std::string& text : texts_of(family)) {
      const Brdf brdf = parsed(text);
      EXPECT_EQ(brdf.kind, family.kind);
      EXPECT_EQ(brdf.specular, glm::vec3(family.specular));
      EXPECT_EQ(brdf_text(brdf, ""), text + (family.has_f0() ? ",0.04,0.04,0.04" : ""));
      EXPECT_EQ(brdf_text(parsed(brdf_text(brdf, "")), ""), brdf_text(brdf, ""));
      EXPECT_TRUE(std::regex_match(text, std::regex(brdf_pattern()))) << text;
      EXPECT_FALSE(is_brdf_file(text));
    }
  }
}

// Tries values a third beyond the ends of the range, a text, and more numbers than any row accepts.
TEST(BrdfTable, EveryRowRefusesWhatIsNotOfIt) {
  for (const BrdfFamily& family : brdf_families()) {
    if (!family.has_width()) continue;
    const BrdfMember& width = family.members[0];
    const std::string low = fmt::format("{:.7g}", width.low);
    for (const std::string& numbers :
         {fmt::format("{:.7g}", 0.75 * width.low), fmt::format("{:.7g}", 1.25 * width.high), std::string(""),
          std::string("x"), std::string("nan"), low + ",0.1,0.2", low + ",1.5", low + ",-0.1", low + ","}) {
      const std::string text = fmt::format("{}:{}", family.name, numbers);
      testing::expect_error(ErrorCode::kUsage, {"--brdf", "'" + text + "'", fmt::format("{}:", family.name)},
                            [&] { parsed(text); });
    }
    EXPECT_EQ(family.has_f0(),
              std::regex_search(expected_brdf(), std::regex(fmt::format("{}:{}\\[,F0\\]", family.name, width.symbol))));
    if (family.has_f0()) continue;
    EXPECT_THROW(parsed(fmt::format("{}:{},0.5", family.name, low)), Error);
  }
}

// The texts and ranges must stay exactly as they were published.
TEST(BrdfTable, FormsAreThoseThatWerePublished) {
  EXPECT_EQ(brdf_text(parsed("cook-torrance:0.07,0.95,0.93,0.88"), ""), "cook-torrance:0.07,0.95,0.93,0.88");
  EXPECT_EQ(brdf_text(parsed("ggx:0.4,0.5"), ""), "ggx:0.4,0.5,0.5,0.5");
  EXPECT_EQ(brdf_text(parsed("blinn-phong:1e5"), ""), "blinn-phong:100000");
  EXPECT_EQ(brdf_text(parsed("torrance-sparrow:.1"), ""), "torrance-sparrow:0.1");
  EXPECT_TRUE(brdf_forms("or").starts_with("lambert, blinn-phong:S, torrance-sparrow:SIGMA, cook-torrance:SIGMA"))
      << brdf_forms("or");
  EXPECT_EQ(range_text(brdf_family(BrdfKind::kBlinnPhong).members[0]), "a number from 1 to 100000");
  EXPECT_EQ(range_text(brdf_family(BrdfKind::kTorranceSparrow).members[0]), "radians from 0.002 to 1");
  EXPECT_EQ(range_text(brdf_family(BrdfKind::kGgx).members[0]), "a number from 0.05 to 1");
}

// No density is negative or extends beyond the sphere. A density integrates to 1 if its row says so, and each fit
// belongs to its row.
TEST(BrdfTable, DensitiesAreWhatRowsSay) {
  for (const BrdfFamily& family : brdf_families())
    for (const std::string& text : texts_of(family)) {
      const Brdf brdf = parsed(text);
      const double total = integrate_zonal([&](double e) { return facet_density(brdf, e); }).x;
      for (const double e : {0.0, 1e-9, 1e-3, 0.5, 1.0 - 1e-9, 1.0, 1.5, 2.0}) {
        const double density = facet_density(brdf, e).x;
        EXPECT_TRUE(std::isfinite(density) && density >= 0.0) << text << " at " << e;
      }
      EXPECT_EQ(family.density == nullptr, family.fit == BrdfFit::kNone) << text;
      if (family.density == nullptr) continue;
      EXPECT_NEAR(facet_total(brdf).x, total, 1e-4 * total) << text;  // 1 if the row says so
      EXPECT_EQ(vmf_terms(brdf).size(), family.fit == BrdfFit::kSum ? 4u : 1u) << text;
      if (family.visibility == nullptr) continue;
      for (const double grazing : {0.0, 1e-9, 1e-3, 1.0}) {
        const double v = grazing * family.visibility(width_of(brdf), grazing, 0.3, 0.5, 0.7);
        EXPECT_TRUE(std::isfinite(v) && v >= 0.0) << text << " at " << grazing;
      }
    }
}

}  // namespace
}  // namespace multum
