// SPDX-License-Identifier: Apache-2.0
// Tests that every search for settings uses its part of one common list, in the order of that list.
#include "host/bakes/settings_search/setting_candidates.h"

#include <gtest/gtest.h>

#include <set>

namespace multum {
namespace {

std::vector<std::string> options_of(const std::vector<SettingCandidate>& candidates) {
  std::vector<std::string> options;
  for (const SettingCandidate& one : candidates) options.push_back(one.options);
  return options;
}

std::vector<std::string> numbered(const std::string& text, int first, int last) {
  std::vector<std::string> options;
  for (int i = first; i <= last; ++i) options.push_back(text + std::to_string(i));
  return options;
}

const std::vector<std::string> kTarget = {"--ndf vmf --lobes 1 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 1",
                                          "--ndf gmm --lobes 1",
                                          "--ndf moments",
                                          "--ndf sh --sh-order 2",
                                          "--ndf vmf --lobes 2 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 2",
                                          "--ndf gmm --lobes 2",
                                          "--ndf vmf --lobes 2 --refine",
                                          "--ndf vmf --lobes 3 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 3",
                                          "--ndf gmm --lobes 3",
                                          "--ndf vmf --lobes 3 --refine",
                                          "--ndf sh --sh-order 3",
                                          "--ndf vmf --lobes 4 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 4",
                                          "--ndf gmm --lobes 4",
                                          "--ndf vmf --lobes 4 --refine",
                                          "--ndf vmf --lobes 5 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 5",
                                          "--ndf gmm --lobes 5",
                                          "--ndf vmf --lobes 5 --refine",
                                          "--ndf sh --sh-order 4",
                                          "--ndf vmf --lobes 6 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 6",
                                          "--ndf gmm --lobes 6",
                                          "--ndf vmf --lobes 6 --refine",
                                          "--ndf vmf --lobes 7 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 7",
                                          "--ndf gmm --lobes 7",
                                          "--ndf vmf --lobes 7 --refine",
                                          "--ndf vmf --lobes 8 --passes 1 --no-start-search",
                                          "--ndf vmf --lobes 8",
                                          "--ndf gmm --lobes 8",
                                          "--ndf vmf --lobes 8 --refine",
                                          "--ndf vmf --lobes 8 --reference",
                                          "--ndf sh --sh-order 6",
                                          "--ndf sh --sh-order 8",
                                          "--ndf sh --sh-order 10",
                                          "--ndf sh --sh-order 13",
                                          "--ndf sh --sh-order 16",
                                          "--ndf sh --sh-order 20"};

const std::vector<std::string> kQuick = {"--ndf vmf --lobes 1",
                                         "--ndf vmf --lobes 2",
                                         "--ndf vmf --lobes 4",
                                         "--ndf vmf --lobes 6",
                                         "--ndf moments",
                                         "--ndf sh --sh-order 4",
                                         "--ndf sh --sh-order 8",
                                         "--ndf gmm --lobes 4",
                                         "--ndf vmf --lobes 4 --passes 1 --no-start-search",
                                         "--ndf vmf --lobes 4 --data-format half",
                                         "--ndf vmf --lobes 2 --first-level 1",
                                         "--ndf vmf --lobes 4 --first-level 1"};

const std::vector<std::string> kDefault = {"--ndf vmf --lobes 1",
                                           "--ndf vmf --lobes 2",
                                           "--ndf vmf --lobes 3",
                                           "--ndf vmf --lobes 4",
                                           "--ndf vmf --lobes 5",
                                           "--ndf vmf --lobes 6",
                                           "--ndf vmf --lobes 7",
                                           "--ndf vmf --lobes 8",
                                           "--ndf moments",
                                           "--ndf sh --sh-order 2",
                                           "--ndf sh --sh-order 4",
                                           "--ndf sh --sh-order 6",
                                           "--ndf sh --sh-order 8",
                                           "--ndf sh --sh-order 12",
                                           "--ndf gmm --lobes 1",
                                           "--ndf gmm --lobes 2",
                                           "--ndf gmm --lobes 4",
                                           "--ndf gmm --lobes 6",
                                           "--ndf vmf --lobes 4 --passes 1 --no-start-search",
                                           "--ndf vmf --lobes 4 --refine",
                                           "--ndf vmf --lobes 4 --data-format half",
                                           "--ndf vmf --lobes 1 --first-level 1",
                                           "--ndf vmf --lobes 2 --first-level 1",
                                           "--ndf vmf --lobes 3 --first-level 1",
                                           "--ndf vmf --lobes 4 --first-level 1",
                                           "--ndf vmf --lobes 6 --first-level 1",
                                           "--ndf vmf --lobes 8 --first-level 1",
                                           "--ndf vmf --lobes 4 --iterations 3",
                                           "--ndf vmf --lobes 4 --iterations 6",
                                           "--ndf vmf --lobes 4 --passes 1",
                                           "--ndf vmf --lobes 4 --passes 3",
                                           "--ndf vmf --lobes 4 --no-start-search",
                                           "--ndf vmf --lobes 4 --reference",
                                           "--ndf vmf --lobes 4 --coarse-normals all",
                                           "--ndf vmf --lobes 4 --unaligned",
                                           "--ndf vmf --lobes 4 --align 0",
                                           "--ndf vmf --lobes 4 --align 1",
                                           "--ndf vmf --lobes 4 --order scanline",
                                           "--ndf vmf --lobes 4 --data-format float",
                                           "--ndf vmf --lobes 4 --first-level 2",
                                           "--ndf vmf --lobes 4 --compression none",
                                           "--ndf vmf --lobes 4 --compression piz"};

const std::vector<std::string> kFull = {"--ndf vmf --lobes 1",
                                        "--ndf vmf --lobes 2",
                                        "--ndf vmf --lobes 3",
                                        "--ndf vmf --lobes 4",
                                        "--ndf vmf --lobes 5",
                                        "--ndf vmf --lobes 6",
                                        "--ndf vmf --lobes 7",
                                        "--ndf vmf --lobes 8",
                                        "--ndf moments",
                                        "--ndf sh --sh-order 2",
                                        "--ndf sh --sh-order 3",
                                        "--ndf sh --sh-order 4",
                                        "--ndf sh --sh-order 6",
                                        "--ndf sh --sh-order 8",
                                        "--ndf sh --sh-order 10",
                                        "--ndf sh --sh-order 13",
                                        "--ndf sh --sh-order 16",
                                        "--ndf sh --sh-order 20",
                                        "--ndf gmm --lobes 1",
                                        "--ndf gmm --lobes 2",
                                        "--ndf gmm --lobes 3",
                                        "--ndf gmm --lobes 4",
                                        "--ndf gmm --lobes 5",
                                        "--ndf gmm --lobes 6",
                                        "--ndf gmm --lobes 7",
                                        "--ndf gmm --lobes 8",
                                        "--ndf vmf --lobes 4 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 4 --refine",
                                        "--ndf vmf --lobes 4 --data-format half",
                                        "--ndf vmf --lobes 1 --first-level 1",
                                        "--ndf vmf --lobes 2 --first-level 1",
                                        "--ndf vmf --lobes 3 --first-level 1",
                                        "--ndf vmf --lobes 4 --first-level 1",
                                        "--ndf vmf --lobes 5 --first-level 1",
                                        "--ndf vmf --lobes 6 --first-level 1",
                                        "--ndf vmf --lobes 7 --first-level 1",
                                        "--ndf vmf --lobes 8 --first-level 1",
                                        "--ndf vmf --lobes 4 --iterations 3",
                                        "--ndf vmf --lobes 4 --iterations 6",
                                        "--ndf vmf --lobes 4 --passes 1",
                                        "--ndf vmf --lobes 4 --passes 3",
                                        "--ndf vmf --lobes 4 --no-start-search",
                                        "--ndf vmf --lobes 4 --reference",
                                        "--ndf vmf --lobes 4 --coarse-normals all",
                                        "--ndf vmf --lobes 4 --unaligned",
                                        "--ndf vmf --lobes 4 --align 0",
                                        "--ndf vmf --lobes 4 --align 1",
                                        "--ndf vmf --lobes 4 --order scanline",
                                        "--ndf vmf --lobes 4 --data-format float",
                                        "--ndf vmf --lobes 4 --first-level 2",
                                        "--ndf vmf --lobes 4 --compression none",
                                        "--ndf vmf --lobes 4 --compression piz",
                                        "--ndf vmf --lobes 1 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 1 --reference",
                                        "--ndf vmf --lobes 2 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 2 --refine",
                                        "--ndf vmf --lobes 2 --reference",
                                        "--ndf vmf --lobes 3 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 3 --refine",
                                        "--ndf vmf --lobes 3 --reference",
                                        "--ndf vmf --lobes 5 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 5 --refine",
                                        "--ndf vmf --lobes 5 --reference",
                                        "--ndf vmf --lobes 6 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 6 --refine",
                                        "--ndf vmf --lobes 6 --reference",
                                        "--ndf vmf --lobes 7 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 7 --refine",
                                        "--ndf vmf --lobes 7 --reference",
                                        "--ndf vmf --lobes 8 --passes 1 --no-start-search",
                                        "--ndf vmf --lobes 8 --refine",
                                        "--ndf vmf --lobes 8 --reference"};

TEST(SettingCandidates, OfATargetAreTheseCheapestFirst) {
  EXPECT_EQ(options_of(target_candidates(std::nullopt)), kTarget);
  EXPECT_EQ(options_of(target_candidates(Representation::kGmm)), numbered("--ndf gmm --lobes ", 1, 8));
  EXPECT_EQ(options_of(target_candidates(Representation::kMoments)), std::vector<std::string>{"--ndf moments"});
  for (const Representation only : {Representation::kMovmf, Representation::kSh}) {
    std::vector<std::string> expected;
    for (const std::string& one : kTarget)
      if (one.starts_with(std::string("--ndf ") + representation_info(only).option)) expected.push_back(one);
    EXPECT_EQ(options_of(target_candidates(only)), expected);
  }
}

TEST(SettingCandidates, OfTheTradeoffAreThese) {
  EXPECT_EQ(options_of(setting_candidates(kQuickSweep)), kQuick);
  EXPECT_EQ(options_of(setting_candidates(kDefaultSweep)), kDefault);
  EXPECT_EQ(options_of(setting_candidates(kFullSweep)), kFull);
}

TEST(SettingCandidates, OfAPlanAreThese) {
  for (const auto& [user, most] : {std::pair(kScenePlan, 4), std::pair(kSceneTarget, 8)}) {
    EXPECT_EQ(options_of(setting_candidates(user, Representation::kMovmf)), numbered("--ndf vmf --lobes ", 1, most));
    EXPECT_EQ(options_of(setting_candidates(user, Representation::kGmm)), numbered("--ndf gmm --lobes ", 1, most));
    EXPECT_EQ(options_of(setting_candidates(user, Representation::kMoments)),
              std::vector<std::string>{"--ndf moments"});
    EXPECT_EQ(options_of(setting_candidates(user, Representation::kSh)),
              (std::vector<std::string>{"--ndf sh --sh-order 2", "--ndf sh --sh-order 4"}));
    EXPECT_EQ(setting_candidates(user).size(), static_cast<std::size_t>(2 * most + 3))
        << "there are no other candidates";
  }
}

TEST(SettingCandidates, AreOnlyOnceInTheListAndSayWhatTheyVary) {
  for (const CandidateUser user : {kTargetSearch, kQuickSweep, kDefaultSweep, kFullSweep, kScenePlan, kSceneTarget}) {
    std::set<std::string> seen;
    for (const SettingCandidate& one : setting_candidates(user)) {
      EXPECT_TRUE(seen.insert(one.options).second) << one.options;
      const std::string axis = candidate_axis_name(one.axis);
      const auto varies = [&](const char* name) { return one.values.is_given(name); };
      EXPECT_EQ(axis == "moments", one.representation() == Representation::kMoments) << one.options;
      EXPECT_EQ(axis == "harmonics", one.representation() == Representation::kSh) << one.options;
      EXPECT_EQ(axis == "Gaussians", one.representation() == Representation::kGmm) << one.options;
      EXPECT_EQ(axis == "first level", varies("first_level")) << one.options;
      EXPECT_EQ(axis == "storage", varies("data_format") || varies("compression")) << one.options;
      EXPECT_EQ(axis == "hierarchy", varies("unaligned") || one.values.has("align") || varies("order")) << one.options;
      EXPECT_GT(one.texture_count, 0) << one.options;
    }
  }
  EXPECT_EQ(default_lobe_count(), MovmfSettings().lobe_count);
}

}  // namespace
}  // namespace multum
