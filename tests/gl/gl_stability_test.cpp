// SPDX-License-Identifier: Apache-2.0
// Every numerical case of the GLSL formulas holds its bound, and breaks it without its guard, by Mesa's software
// renderer. With MULTUM_STABILITY_JSON=FILE in the environment the verdicts are written there, for docs/STABILITY.md.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "host/base/atomic_file.h"
#include "host/reference/case_page.h"
#include "host/reference/case_table.h"
#include "tests/gl/glsl_cases.h"

namespace multum::gl {
namespace {

NumericalVerdict verdict_of(const GlslCase& c, const GlFunctions& gl) {
  WorstError worst, without;
  c.run(gl, {}, worst);
  c.run(gl, c.without, without);
  EXPECT_GT(worst.count(), 0u) << c.text.name << " compares nothing";
  return {c.text, worst.value(), worst.input(), without.value()};
}

TEST(GlslCases, HoldWithTheirGuardsAndBreakWithout) {
  const auto context = make_headless_context(ContextBackend::kOsmesa);
  NumericalRun run{"GL", context->description(), "Mesa", "OSMesa", std::string("multum ") + MULTUM_VERSION, {}};
  for (const GlslCase& c : glsl_cases()) {
    run.verdicts.push_back(verdict_of(c, context->functions()));
    const NumericalVerdict& v = run.verdicts.back();
    EXPECT_TRUE(v.holds()) << c.text.name << ": worst " << error_text(v.worst) << " at " << v.worst_input << ", bound "
                           << error_text(c.text.bound);
    EXPECT_TRUE(v.guard_matters()) << c.text.name << ": without its guard the worst error is "
                                   << error_text(*v.without_guard) << ", within the bound of "
                                   << error_text(c.text.bound);
  }
  std::fputs(case_table(run).c_str(), stdout);
  if (const char* path = std::getenv("MULTUM_STABILITY_JSON")) write_text_file(path, case_json(run));
}

TEST(GlslCases, AreWhatThePageHas) {
  std::ifstream in(MULTUM_SOURCE_DIR "/docs/STABILITY.md");
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  const std::size_t begin = page.find("\n## movmf_shading.glsl");
  ASSERT_NE(begin, std::string::npos) << "docs/STABILITY.md says how it is made again";
  std::vector<std::string> names;
  for (const GlslCase& c : glsl_cases()) names.push_back(c.text.name);
  EXPECT_EQ(cases_of_page(page.substr(begin)), names) << "docs/STABILITY.md says how it is made again";
}

}  // namespace
}  // namespace multum::gl
