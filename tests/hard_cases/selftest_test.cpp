// SPDX-License-Identifier: Apache-2.0
// Every numerical case of the kernels must stay within its bound, and must exceed the bound without its guard. A case
// that could not fail would prove nothing. docs/contributing/STABILITY.md lists exactly these cases.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>

#include "host/foundation/base/error.h"
#include "host/lab/reference/case_page.h"
#include "host/lab/reference/case_table.h"
#include "host/lab/reference/case_topics.h"
#include "host/lab/selftest/selftest.h"
#include "tests/fixtures/test_device.h"
#ifdef MULTUM_HAS_FIELDS
#include "host/lab/field_cases/field_cases.h"
#endif

namespace multum {
namespace {

using testing::test_device;

#ifdef MULTUM_HAS_FIELDS
// The cases must be registered before the suite below uses them.
const bool g_has_field_cases = (register_field_cases(), true);
#else
const bool g_has_field_cases = false;
#endif

std::vector<std::string> formulas() {
  std::vector<std::string> found;
  for (const NumericalCase& c : numerical_cases())
    if (std::find(found.begin(), found.end(), c.text.formula) == found.end()) found.push_back(c.text.formula);
  return found;
}

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Returns the names of all kernels in the kernel sources.
std::set<std::string> all_kernels() {
  std::set<std::string> kernels;
  const std::regex head("__kernel void (\\w+)\\(");
  for (const auto& entry : std::filesystem::directory_iterator(MULTUM_SOURCE_DIR "/kernels")) {
    if (entry.path().extension() != ".cl") continue;
    const std::string text = text_of_file(entry.path());
    for (std::sregex_iterator i(text.begin(), text.end(), head), end; i != end; ++i) kernels.insert((*i)[1]);
  }
  return kernels;
}

std::vector<std::string> kernels_of(const NumericalCase& c) {
  static const std::set<std::string> all = all_kernels();
  std::vector<std::string> kernels = split_names(c.text.formula);
  std::erase_if(kernels, [](const std::string& name) { return all.count(name) == 0; });
  return kernels;
}

std::uint64_t launches_of(const std::string& kernel, const std::map<std::string, std::uint64_t>& counts) {
  const auto found = counts.find(kernel);
  return found == counts.end() ? 0 : found->second;
}

class SelftestCases : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Of, SelftestCases, ::testing::ValuesIn(formulas()), [](const auto& formula) {
  std::string name = formula.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

TEST_P(SelftestCases, HoldWithTheirGuardsAndBreakWithout) {
  for (const NumericalCase& c : numerical_cases()) {
    if (c.text.formula != GetParam()) continue;
    const std::map<std::string, std::uint64_t> before = test_device().launch_counts();
    const NumericalVerdict verdict = run_case(c, test_device(), true);
    for (const std::string& kernel : kernels_of(c))
      EXPECT_GT(launches_of(kernel, test_device().launch_counts()), launches_of(kernel, before))
          << c.text.name << " does not launch " << kernel;
    EXPECT_TRUE(verdict.holds()) << c.text.name << ": worst " << error_text(verdict.worst) << " at "
                                 << verdict.worst_input << ", bound " << error_text(c.text.bound);
    // With PoCL, a case fails without its guard. The arithmetic of another device may not need the guard.
    if (!test_device().info().is_cpu) continue;
    EXPECT_TRUE(verdict.can_fail()) << c.text.name << ": without its guard the worst error is "
                                    << tried_text(verdict.without_guard) << ", with its bug "
                                    << tried_text(verdict.mutated) << ", within the bound of "
                                    << error_text(c.text.bound);
  }
}

TEST(SelftestRegistry, CasesSayWhatTheyAre) {
  std::set<std::string> names;
  for (const NumericalCase& c : numerical_cases()) {
    EXPECT_TRUE(names.insert(c.text.name).second) << c.text.name << " is there twice";
    EXPECT_EQ(c.text.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-"), std::string::npos) << c.text.name;
    EXPECT_EQ((c.without.empty() ? 0 : 1) + (c.naive ? 1 : 0) + (c.mutation.empty() ? 0 : 1), 1)
        << c.text.name << " must prove in exactly one way that it can fail";
    EXPECT_EQ(fault_of_guards(c.without), "") << c.text.name;
    for (const std::string& text :
         {c.text.formula, c.text.without_guard, c.text.guard, c.text.unit, c.text.bound_reason})
      EXPECT_FALSE(text.empty()) << c.text.name;
    EXPECT_GT(c.text.bound, 0.0) << c.text.name;
  }
}

// Two cases of one kernel with the same edit would prove the same fact.
TEST(SelftestRegistry, EditsAreOneCasesOwn) {
  std::map<std::string, std::string> owners;  // formula and edits, case
  for (const NumericalCase& c : numerical_cases()) {
    const auto claim = [&](const std::vector<SourceEdit>& edits) {
      std::string key = c.text.formula;
      for (const SourceEdit& edit : edits) key += "\n" + edit.file + "\n" + edit.text + "\n" + edit.replacement;
      const auto [owner, is_new] = owners.emplace(key, c.text.name);
      EXPECT_TRUE(is_new) << c.text.name << " uses the same edit as " << owner->second;
    };
    for (const SourceEdit& guard : c.without) claim({guard});
    if (!c.mutation.empty()) claim(c.mutation);
  }
}

TEST(SelftestRegistry, AGuardIsTakenOutAndNotChanged) {
  EXPECT_EQ(fault_of_guards({{"f", "max(x, 1e-6f)", "x"}, {"f", "if (e > 0.1f) return", "if (true) return"}}), "");
  EXPECT_NE(fault_of_guards({{"f", "max(x, 1e-6f)", "max(x, 1e-1f)"}}), "");
  EXPECT_NE(fault_of_guards({{"f", "#define AMPLITUDE_MIN 1e-6f", "#define AMPLITUDE_MIN 0.0f"}}), "");
  EXPECT_NE(fault_of_guards({{"f", "e < 1.0f", "e < -1.0f"}}), "");
  EXPECT_NE(fault_of_guards({{"f", "a", "b"}, {"f", "a", ""}}), "");
}

TEST(SelftestRegistry, EveryKernelHasACase) {
  if (!g_has_field_cases) GTEST_SKIP() << "built without fields";
  std::set<std::string> without = all_kernels();
  EXPECT_GT(without.size(), 25u);
  for (const NumericalCase& c : numerical_cases())
    for (const std::string& kernel : kernels_of(c)) without.erase(kernel);
  for (const std::string& kernel : without)
    ADD_FAILURE() << kernel << " has no numerical case (host/lab/selftest/*_cases.cpp) that names it";
}

TEST(SelftestRegistry, IsWhatThePageHas) {
  if (!g_has_field_cases) GTEST_SKIP() << "built without fields";
  const std::string page = text_of_file(MULTUM_SOURCE_DIR "/docs/contributing/STABILITY.md");
  std::vector<std::string> names;
  for (const NumericalCase& c : numerical_cases()) names.push_back(c.text.name);
  // The page lists them by kernel.
  std::vector<std::string> of_page = cases_of_page(page.substr(0, page.find("\n## movmf_shading.glsl")));
  std::sort(names.begin(), names.end());
  std::sort(of_page.begin(), of_page.end());
  EXPECT_EQ(of_page, names) << "docs/contributing/STABILITY.md says how to make the page again";
}

TEST(SelftestRegistry, TopicsNameWhatThereIs) {
  const std::string page = text_of_file(MULTUM_SOURCE_DIR "/docs/contributing/STABILITY.md"),
                    bakes = text_of_file(MULTUM_SOURCE_DIR "/tests/hard_cases/bake_hard_cases_test.cpp");
  const std::vector<std::string> of_page = cases_of_page(page);
  const std::set<std::string> names(of_page.begin(), of_page.end());
  for (const CaseTopic& topic : case_topics()) {
    EXPECT_NE(page.find(topic.danger), std::string::npos) << topic.danger;
    for (const std::string& name : topic.cases) {
      const std::size_t dot = name.find('.');
      if (dot == std::string::npos) {
        EXPECT_EQ(names.count(name), 1u) << "no case is called " << name;
      } else {
        EXPECT_NE(bakes.find("(" + name.substr(0, dot) + ", " + name.substr(dot + 1) + ")"), std::string::npos) << name;
      }
    }
  }
}

// Simulates a driver that removes a guard, so that the compiled kernel differs from its source.
TEST(SelftestRun, NamesABrokenGuard) {
  Device device = Device::open("");
  device.edit_kernels({{"probe_numerics", "isnan(x) ? 1.0f : 0.0f", "0.0f"}});
  const NumericalRun run = run_selftest(device, {"driver-", false}, nullptr);
  EXPECT_FALSE(run.holds());
  ASSERT_EQ(run.verdicts.size(), 2u);
  EXPECT_FALSE(run.verdicts[0].holds());
  EXPECT_TRUE(run.verdicts[1].holds());
  EXPECT_NE(case_table(run).find("driver-keeps-nan"), std::string::npos);
  EXPECT_NE(case_table(run).find("BROKEN (probe_functions, at input nan)"), std::string::npos) << case_table(run);
  EXPECT_FALSE(run.device.empty() || run.platform.empty() || run.driver.empty());
}

TEST(SelftestRun, RefusesAFilterThatLeavesNothing) {
  try {
    run_selftest(test_device(), {"no such case", false}, nullptr);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("no such case"), std::string::npos);
  }
}

TEST(SelftestRun, CancelsBetweenCases) {
  int events = 0;
  Progress progress([&](const ProgressEvent&) { return ++events < 3; });
  EXPECT_THROW(run_selftest(test_device(), {"kappa-12-decades", false}, &progress), Cancelled);
  EXPECT_NO_THROW(run_selftest(test_device(), {"kappa-12-decades", false}, nullptr));
}

TEST(WorstErrorTest, NotANumberIsWorst) {
  WorstError worst;
  worst.add(1.0, "one");
  worst.add(std::nan(""), "nan");
  worst.add(HUGE_VAL, "inf");
  EXPECT_TRUE(std::isnan(worst.value()));
  EXPECT_EQ(worst.input(), "nan");
  EXPECT_FALSE((NumericalVerdict{{"", "", "", "", 1.0, "", ""}, worst.value(), "", {}, {}}).holds());
}

TEST(CaseJson, ComesBack) {
  NumericalRun run{"OpenCL", "d", "p", "v", "s", {}};
  run.verdicts.push_back({{"a", "f", "w", "g", 1e-6, "u", "r"}, std::nan(""), "here", HUGE_VAL, {}});
  run.verdicts.push_back({{"b", "f", "w", "g", 1e-6, "u", "r"}, 1e-7, "there", {}, 0.5});
  const NumericalRun back = parse_case_json(case_json(run), "x.json");
  EXPECT_EQ(case_json(back), case_json(run));
  EXPECT_EQ(stability_page({back}), stability_page({run}));
  const std::string page = stability_page({run});
  EXPECT_NE(page.find("| bound | worst | without | mutated |"), std::string::npos) << page;
  EXPECT_NE(page.find("| 1.0e-07 | - | 5.0e-01 |"), std::string::npos) << page;
  EXPECT_EQ(cases_of_page(stability_page({run})), (std::vector<std::string>{"a", "b"}));
  EXPECT_FALSE(back.verdicts[0].holds());
  EXPECT_TRUE(back.verdicts[0].can_fail() && back.verdicts[1].can_fail());
  EXPECT_THROW(parse_case_json("{}", "x.json"), Error);
}

}  // namespace
}  // namespace multum
