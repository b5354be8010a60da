// SPDX-License-Identifier: Apache-2.0
// Tests the sentences, the advice and the gain that follow from measured errors.
#include "host/delivery/check/gain_verdict.h"

#include <gtest/gtest.h>

#include <vector>

namespace multum::testing {
namespace {

// Errors that are equal under both lights.
struct FromDistance {
  double distance, plain, exported, lobes;
};

GainVerdict verdict_of(const std::vector<FromDistance>& errors, std::optional<double> roughness = 0.3) {
  GainVerdict made{"map.png", "", {}, roughness};
  for (const FromDistance& at : errors)
    for (const GainLight light : {GainLight::kSun, GainLight::kSky})
      made.measured.push_back({at.distance, roughness, light, at.plain, at.exported, at.lobes, 0.1});
  return made;
}

TEST(GainVerdictTest, AFlatMapKeepsItsMips) {
  const GainVerdict verdict = verdict_of({{2.0, 0.1, 0.1, 0.0}, {5.0, 0.9, 0.5, 0.1}});
  EXPECT_EQ(verdict.to_text(), "flat: keep your mips (their error is at most 0.9 %)");
  EXPECT_EQ(verdict.advice(), GainAdvice::kKeep);
  EXPECT_NEAR(verdict.gain(), 0.8, 1e-9);
}

TEST(GainVerdictTest, AMapThatGainsLittleKeepsItsMips) {
  const GainVerdict verdict = verdict_of({{2.0, 4.0, 4.0, 3.5}, {5.0, 9.0, 8.5, 8.2}});
  EXPECT_EQ(verdict.to_text(), "at 5 m and roughness 0.3: plain mips 9.0 %, export 8.5 %, lobes 8.2 %; keep your mips");
  EXPECT_EQ(verdict.advice(), GainAdvice::kKeep);
}

TEST(GainVerdictTest, EachFormIsWorthItFromADistance) {
  const GainVerdict verdict =
      verdict_of({{1.0, 3.0, 3.0, 2.5}, {2.0, 9.0, 8.8, 5.0}, {5.0, 21.0, 14.0, 6.0}, {25.0, 20.0, 19.5, 19.0}});
  EXPECT_EQ(verdict.to_text(),
            "at 5 m and roughness 0.3: plain mips 21.0 %, export 14.0 %, lobes 6.0 %; the export is worth it from 5 m "
            "on, lobes are worth it from 2 m on");
  EXPECT_EQ(verdict.advice(), GainAdvice::kLobes);
  EXPECT_NEAR(verdict.gain(), 15.0, 1e-9);
}

TEST(GainVerdictTest, TheSentenceStatesTheLargestGainIfThereIsNoneAtFiveMetres) {
  const GainVerdict verdict = verdict_of({{5.0, 3.0, 3.0, 2.9}, {25.0, 12.0, 8.0, 8.0}}, std::nullopt);
  EXPECT_EQ(verdict.to_text(),
            "at 25 m: plain mips 12.0 %, export 8.0 %, lobes 8.0 %; the export is worth it from 25 m on");
  EXPECT_EQ(verdict.advice(), GainAdvice::kExport);
}

TEST(GainVerdictTest, AnExportThatIsWorseIsNotWorthIt) {
  const GainVerdict verdict = verdict_of({{1.0, 5.0, 9.0, 6.0}});
  EXPECT_EQ(verdict.advice(), GainAdvice::kKeep);
  EXPECT_EQ(verdict.gain(), 0.0);
}

TEST(GainVerdictTest, OtherRoughnessIsInTheTableOnly) {
  GainVerdict verdict = verdict_of({{5.0, 3.0, 3.0, 2.9}});
  verdict.measured.push_back({5.0, 0.1, GainLight::kSun, 50.0, 20.0, 10.0, 0.1});
  EXPECT_EQ(verdict.advice(), GainAdvice::kKeep);
  EXPECT_NE(verdict.to_table().find("50.0 %"), std::string::npos);
  EXPECT_EQ(verdict.to_json()["errors"].size(), 3u);
}

}  // namespace
}  // namespace multum::testing
