// SPDX-License-Identifier: Apache-2.0
// Tests the numerical cases of the GLSL formulas with Mesa's software renderer. Every case must stay within its bound,
// and must exceed the bound without its guard. For every shader function there must be a case that fails if the
// function is broken. If MULTUM_STABILITY_JSON=FILE is set in the environment, the test writes the verdicts to FILE for
// docs/contributing/STABILITY.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>

#include "host/foundation/base/files/atomic_file.h"
#include "host/lab/reference/case_page.h"
#include "host/lab/reference/case_table.h"
#include "tests/gl/glsl/glsl_cases.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

NumericalVerdict verdict_of(const GlslCase& c, const GlFunctions& gl) {
  WorstError worst;
  c.run(gl, {}, worst);
  EXPECT_GT(worst.count(), 0u) << c.text.name << " compares nothing";
  NumericalVerdict verdict{c.text, worst.value(), worst.input(), {}, {}};
  for (const SourceEdit& guard : c.without) {
    WorstError without;
    c.run(gl, {guard}, without);
    verdict.without_guard =
        verdict.without_guard ? least_error(*verdict.without_guard, without.value()) : without.value();
  }
  if (!c.mutation.empty()) {
    WorstError mutated;
    c.run(gl, c.mutation, mutated);
    verdict.mutated = mutated.value();
  }
  return verdict;
}

TEST(GlslCases, HoldWithTheirGuardsAndBreakWithout) {
  const auto context = make_test_context(test_backend());
  NumericalRun run{"GL", context->description(), "Mesa", "OSMesa", std::string("multum ") + MULTUM_VERSION, {}};
  for (const GlslCase& c : glsl_cases()) {
    run.verdicts.push_back(verdict_of(c, context->functions()));
    const NumericalVerdict& v = run.verdicts.back();
    EXPECT_TRUE(v.holds()) << c.text.name << ": worst " << error_text(v.worst) << " at " << v.worst_input << ", bound "
                           << error_text(c.text.bound);
    EXPECT_EQ(fault_of_guards(c.without), "") << c.text.name;
    EXPECT_TRUE(v.can_fail()) << c.text.name << ": without its guard the worst error is " << tried_text(v.without_guard)
                              << ", with its bug " << tried_text(v.mutated) << ", within the bound of "
                              << error_text(c.text.bound);
  }
  std::fputs(case_table(run).c_str(), stdout);
  if (const char* path = std::getenv("MULTUM_STABILITY_JSON")) write_text_file(path, case_json(run));
}

// Identifies a function of runtime_gl/shaders by its file, its name, and its text before the brace.
struct Formula {
  std::string file, name, type, head;
};

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<Formula> all_formulas() {
  const std::regex head("(?:^|\n)((\\w+) (multum_\\w+)\\([^)]*\\) \\{)");
  std::vector<Formula> formulas;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(MULTUM_SOURCE_DIR "/runtime_gl/shaders")) {
    if (entry.path().extension() == ".h" || !entry.is_regular_file()) continue;
    const std::string text = text_of_file(entry.path());
    for (std::sregex_iterator i(text.begin(), text.end(), head), end; i != end; ++i)
      formulas.push_back({entry.path().filename().string(), (*i)[3], (*i)[2], (*i)[1]});
  }
  return formulas;
}

bool is_of(const GlslCase& c, const Formula& f) {
  const std::vector<std::string> files = split_names(c.text.formula);
  return std::find(files.begin(), files.end(), f.file) != files.end() &&
         std::find(c.functions.begin(), c.functions.end(), f.name) != c.functions.end();
}

// Lists the functions whose faults appear only in pictures, and the tests of these pictures.
const std::map<std::string, std::string> kByPictures = {
    {"texture_filter.glsl multum_footprint", "TextureFilterTest, TapsAreTheirsInDouble"},
    {"texture_filter.glsl multum_first_tap", "TextureFilterTest, TapsAreTheirsInDouble"},
    {"texture_filter.glsl multum_filtered", "TextureFilterTest, TapsAreTheirsInDouble"},
    {"texture_filter.glsl multum_normal_map_lobe", "FirstLevelViewTest, NearTheNormalMapIsTheSurfaceBetweenTexels"},
    {"sh.glsl multum_sh_environment_specular", "EnvironmentTest, HarmonicsOfNormalsAreShaded"},
    {"scene.frag multum_frame_at", "EvaluationsTest, LobesTurnWithTheMesh"},
    {"scene.frag multum_fetch_at", "EvaluationsTest, PointsAreNearer"},
    {"scene.frag multum_fetch_turned", "EvaluationsTest, LobesTurnWithTheMesh"},
    {"scene.frag multum_evaluated", "EvaluationsTest, PointsAreNearer"},
    {"lobes.glsl multum_surface_size", "EvaluationsTest, AFlatMapIsTheSameByAnyBudget"},
    {"normals.glsl multum_surface_size", "EvaluationsTest, PointsAreNearer"},
    {"sh.glsl multum_surface_size", "EvaluationsTest, AFlatMapIsTheSameByAnyBudget"},
    {"movmf.glsl multum_add_up", "EvaluationsTest, NormalsThatScatterAreShadedAsLobes"},
    {"movmf.glsl multum_add_up_alike", "EvaluationsTest, LobesThatAreAlikeAreAddedUpFirst"},
    {"lobes.glsl multum_alike_parts", "EvaluationsTest, LobesThatAreAlikeAreAddedUpFirst"},
    {"lobes.glsl multum_magnify", "TextureFilterTest, AMagnifiedSurfaceIsThatOfAveragedNormals"},
    {"lobes.glsl multum_make_whole", "LobeExportTest, MultumViewDrawsIt"},
    {"normals.glsl multum_turned_mean", "EvaluationsTest, WhatHasNoLobesWidensWhereTheMeshTurns"},
    {"normals.glsl multum_turned_exponent", "EvaluationsTest, WhatHasNoLobesWidensWhereTheMeshTurns"},
    {"normals.glsl multum_turned_slopes", "EvaluationsTest, WhatHasNoLobesWidensWhereTheMeshTurns"},
    {"scene.frag multum_take_turn", "EvaluationsTest, WhatHasNoLobesWidensWhereTheMeshTurns"},
    {"movmf.glsl multum_spread_of_all", "EvaluationsTest, NormalsThatScatterAreShadedAsLobes"},
    {"lobes.glsl multum_surface_footprint", "TextureFilterTest, AFlatMapIsTheSameByEveryFilter"},
    {"lobes.glsl multum_lobe_map_size", "RenderTest, TwoTiltsEqualReferenceWhereMipsFail"},
    {"lobes.glsl multum_unpacking", "LobeExportTest, MultumViewDrawsIt"},
    {"lobes.glsl multum_fetch_lobe", "LobeExportTest, MultumViewDrawsIt"},
    {"lobes.glsl multum_numbers_drawn", "DrawnLobeTest, TheMeanOfFramesIsTheSum"},
    {"lobes.glsl multum_draw_lobe", "DrawnLobeTest, TheMeanOfFramesIsTheSum"},
    {"roughness_texture.glsl multum_roughness_footprint", "RenderTest, ARoughnessTextureEqualsTheReference"},
    {"roughness_texture.glsl multum_take_roughness", "RenderTest, ARoughnessTextureEqualsTheReference"},
    {"lobes.glsl multum_mean_colour", "TextureFilterTest, ColoursOfAnotherSizeHaveTheirOwnLevel"},
    {"normals.glsl multum_surface_footprint", "TextureFilterTest, TapsAreTheirsInDouble"},
    {"normals.glsl multum_interpolated_normal", "TextureFilterTest, ReferencesBetweenTexels"},
    {"sh.glsl multum_surface_footprint", "TextureFilterTest, AFlatMapIsTheSameByEveryFilter"},
    {"lobes.glsl multum_fetch_surface", "RenderTest, TwoTiltsEqualReferenceWhereMipsFail"},
    {"normals.glsl multum_fetch_surface", "RenderTest, MomentsEqualTheBaselines"},
    {"sh.glsl multum_fetch_surface", "ShRenderTest, AFlatMapIsItsBrdfCutOff"},
    {"layer_sum.frag multum_rounded_to_half", "LayerSumTest, EqualsTheDecoderAndItsMipLevels"},
    {"layer_sum.frag multum_rounded_to_halves", "LayerSumTest, EqualsTheDecoderAndItsMipLevels"},
    {"layer_sum.frag multum_cover", "LayerSumTest, EqualsTheDecoderAndItsMipLevels"},
    {"environment_samples.glsl multum_environment_normal", "EnvironmentTest, BruteForceIsTheSumOverTheTexels"}};

TEST(GlslCases, EveryFormulaHasOne) {
  std::string pictures;
  for (const char* folder : {MULTUM_SOURCE_DIR "/tests/gl", MULTUM_SOURCE_DIR "/tests/cli/exports"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) pictures += text_of_file(entry.path());
  const std::vector<Formula> formulas = all_formulas();
  EXPECT_GT(formulas.size(), 80u);
  for (const Formula& f : formulas) {
    const auto seen = kByPictures.find(f.file + " " + f.name);
    if (seen != kByPictures.end()) {
      const bool is_test = pictures.find("TEST_P(" + seen->second + ")") != std::string::npos ||
                           pictures.find("TEST_F(" + seen->second + ")") != std::string::npos;
      EXPECT_TRUE(is_test) << seen->second << ": unknown test";
      continue;
    }
    EXPECT_TRUE(std::any_of(glsl_cases().begin(), glsl_cases().end(), [&](const GlslCase& c) { return is_of(c, f); }))
        << f.name << " of " << f.file << " has no numerical case (tests/gl/glsl/*_cases.cpp) that names it";
  }
  for (const GlslCase& c : glsl_cases())
    for (const std::string& function : c.functions)
      EXPECT_TRUE(std::any_of(formulas.begin(), formulas.end(),
                              [&](const Formula& f) { return f.name == function && is_of(c, f); }))
          << c.text.name << " names " << function << ", which " << c.text.formula << " has not";
}

// Makes the function return at once, with a value that no formula gives.
SourceEdit broken(const Formula& f) {
  const std::map<std::string, std::string> values = {
      {"void", ""},           {"MultumReflection", "MultumReflection(vec3(-7e8), vec3(-7e8))"}, {"uint", "7u"},
      {"mat3", "mat3(-7e8)"}, {"MultumFootprint", "MultumFootprint(vec2(-7e8), -7, -7e8)"},     {"ivec2", "ivec2(-7)"},
      {"int", "-7"}};
  const auto value = values.find(f.type);
  return glsl_edit(f.head, f.head + " return " + (value != values.end() ? value->second : f.type + "(-7e8)") + ";\n");
}

TEST(GlslCases, ABrokenFormulaBreaksThoseThatNameIt) {
  const auto context = make_test_context(test_backend());
  for (const Formula& f : all_formulas())
    for (const GlslCase& c : glsl_cases()) {
      if (!is_of(c, f)) continue;
      WorstError worst;
      c.run(context->functions(), {broken(f)}, worst);
      EXPECT_FALSE(worst.value() <= c.text.bound) << c.text.name << " does not notice that " << f.name << " is broken";
    }
}

TEST(GlslCases, AreWhatThePageHas) {
  const std::string page = text_of_file(MULTUM_SOURCE_DIR "/docs/contributing/STABILITY.md");
  const std::size_t begin = page.find("\n## movmf_shading.glsl");
  ASSERT_NE(begin, std::string::npos) << "docs/contributing/STABILITY.md says how it is made again";
  std::vector<std::string> names;
  for (const GlslCase& c : glsl_cases()) names.push_back(c.text.name);
  std::vector<std::string> of_page = cases_of_page(page.substr(begin));
  std::sort(names.begin(), names.end());
  std::sort(of_page.begin(), of_page.end());
  EXPECT_EQ(of_page, names) << "docs/contributing/STABILITY.md says how it is made again";
}

}  // namespace
}  // namespace multum::gl
