// SPDX-License-Identifier: Apache-2.0
// Tests that manifests give the same jobs as the same options on the command line. Each error message names the line,
// the key, the value found and the value expected.
#include "host/bakes/manifest/bake_manifest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "host/bakes/bake/output_state.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

const std::string kManifest =
    "[defaults]\n"
    "lobes = 3\n"
    "signed = true\n"
    "error_max = 0.5\n"
    "albedo = \"colour.png\"\n"
    "\n"
    "[[map]]\n"
    "input = \"a.png\"\n"
    "output = \"out/a.ndf.exr\"\n"
    "\n"
    "[[map]]\n"
    "input = \"b.png\"\n"
    "output = \"out/b.exr\"\n"
    "lobes = 2\n"
    "unsigned = true\n"
    "albedo = \"\"\n"
    "error_max = 0.25\n";

class BakeManifestTest : public ::testing::Test {
 protected:
  std::string path() const { return folder_ / "maps.toml"; }
  std::vector<ManifestMap> read(const std::string& text) const {
    write_bytes(path(), text);
    return read_bake_manifest(path(), pattern_);
  }
  // Replaces the first `from` by `to`. The error message must name that line and contain all of `parts`.
  void expect_refused(const std::string& from, const std::string& to, std::vector<std::string> parts) const {
    SCOPED_TRACE(to);
    const std::size_t at = kManifest.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::string text = kManifest;
    text.replace(at, from.size(), to);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    parts.insert(parts.begin(), path() + ":" + std::to_string(line) + ": ");
    expect_error(ErrorCode::kInput, parts, [&] { read(text); });
  }

  TemporaryFolder folder_;
  BakeJob pattern_;
};

TEST_F(BakeManifestTest, MapsStandOnTheDefaults) {
  pattern_.threads = 7;
  const std::vector<ManifestMap> maps = read(kManifest);
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[0].name, "out/a.ndf.exr");
  EXPECT_EQ(maps[0].job.input, folder_ / "a.png");
  EXPECT_EQ(maps[0].job.output, folder_ / "out/a.ndf.exr");
  EXPECT_EQ(maps[0].job.albedo, folder_ / "colour.png");
  EXPECT_EQ(maps[0].job.fitting.lobe_count, 3);
  EXPECT_EQ(maps[0].job.reading.is_signed, true);
  EXPECT_EQ(maps[0].error_max, 0.5);
  EXPECT_EQ(maps[0].job.threads, 7) << "the pattern's";
  EXPECT_EQ(maps[1].job.fitting.lobe_count, 2);
  EXPECT_EQ(maps[1].job.reading.is_signed, false) << "the map's 'unsigned' overrides 'signed' of the defaults";
  EXPECT_EQ(maps[1].job.albedo, "");
  EXPECT_EQ(maps[1].error_max, 0.25);
  EXPECT_EQ(read("[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\n")[0].error_max, std::nullopt);
}

TEST_F(BakeManifestTest, UnalignedIsWithoutParentsPriorOrSecondPass) {
  const MovmfSettings fit = read("[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\nunaligned = true\n")[0].job.fitting;
  EXPECT_FALSE(fit.aligned_start);
  EXPECT_EQ(fit.alignment, 0.0f);
  EXPECT_EQ(fit.pass_count, 1);
}

TEST_F(BakeManifestTest, RefitIterationsGoBeforeThoseOfReference) {
  const std::string map = "[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\n";
  EXPECT_EQ(read(map)[0].job.fitting.refit_iterations, 6);
  EXPECT_EQ(read(map + "reference = true\n")[0].job.fitting.refit_iterations, 10);
  EXPECT_EQ(read(map + "reference = true\nrefit_iterations = 3\n")[0].job.fitting.refit_iterations, 3);
}

// Sets every key to a value other than its default, and compares the result with options that are set by hand. Both
// must give the same settings in the file.
TEST_F(BakeManifestTest, EveryKeyIsTheOptionOfItsName) {
  const std::string whole =
      "[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\nlobes = 5\nreference = true\niterations = 9\npasses = 3\n"
      "refit_iterations = 8\norder = \"scanline\"\nalign = 0.3\nkappa_cap = 250\nfirst_level = 2\ndata_format = "
      "\"half\"\n"
      "compression = \"zips:4\"\nwrap = \"clamp\"\nswrap = \"mirror\"\ngreen = \"down\"\ntwo_channel = true\n"
      "signed = true\nbumpformat = \"height\"\nheight_scale = -2.5\nfixnan = \"none\"\nchecknan = true\n"
      "repair_max = 0.125\nno_start_search = true\ncoarse_normals = \"binned\"\nrefine = true\n";
  const BakeJob job = read(whole)[0].job;
  BakeJob expected;
  expected.fitting.convergence_tolerance = 0.0f;  // as with --reference
  expected.fitting.lobe_count = 5;
  expected.fitting.iteration_count = expected.fitting.iteration_count_coarse = 9;
  expected.fitting.pass_count = 3;
  expected.fitting.refit_iterations = 8;
  expected.fitting.refine = true;
  expected.fitting.order = FitOrder::kScanline;
  expected.fitting.alignment = 0.3f;
  expected.fitting.kappa_cap = 250.0f;
  expected.fitting.first_level = 2;
  expected.fitting.search_start = false;
  expected.encoding = StorageEncoding::kHalf;
  expected.writing.compression = "zips:4";
  expected.reading.wrap_s = WrapMode::kMirror;
  expected.reading.wrap_t = WrapMode::kClamp;
  expected.reading.green = GreenAxis::kDown;
  expected.reading.two_channel = expected.reading.is_signed = true;
  expected.reading.bump_format = BumpFormat::kHeight;
  expected.reading.height_scale = -2.5f;
  expected.reading.fix_nan = FixNan::kNone;
  EXPECT_EQ(all_settings_json(job), all_settings_json(expected));
  EXPECT_TRUE(job.reading.check_nan);
  EXPECT_EQ(job.reading.repair_share_max, 0.125f);
  const BakeJob other =
      read("[defaults]\ncoarse_normals = \"all\"\ntwrap = \"black\"\n[[map]]\ninput = \"a\"\noutput = \"a.exr\"")[0]
          .job;
  EXPECT_EQ(other.fitting.coarse_normals, CoarseNormals::kAll);
  EXPECT_EQ(other.reading.wrap_s, WrapMode::kPeriodic);
  EXPECT_EQ(other.reading.wrap_t, WrapMode::kBlack);
}

TEST_F(BakeManifestTest, UnknownKeysNameTheNearest) {
  expect_refused("lobes = 2", "lobse = 2", {"map.lobse", "unknown key", "map.lobes"});
  expect_refused("lobes = 3", "qqqqqqqqqq = 3", {"defaults.qqqqqqqqqq", "unknown key"});
  expect_refused("lobes = 3", "input = \"a\"", {"defaults.input", "unknown key"});
  expect_refused("[defaults]", "[default]", {"default", "unknown key", "defaults"});
}

TEST_F(BakeManifestTest, WhatMustBeThere) {
  expect_error(ErrorCode::kInput, {path(), "the manifest", "no map"}, [&] { read("[defaults]\nlobes = 3\n"); });
  expect_error(ErrorCode::kInput, {path() + ":1: ", "a table", "[[map]]"}, [&] { read("[map]\ninput = \"a\"\n"); });
  expect_error(ErrorCode::kInput, {path() + ":3: ", "map", "no output"},
               [&] { read("[defaults]\n\n[[map]]\ninput = \"a\"\n"); });
  expect_error(ErrorCode::kInput, {path() + ":2: ", "map", "no input"},
               [&] { read("\n[[map]]\noutput = \"a.exr\"\n"); });
  expect_error(ErrorCode::kInput, {path() + ":2: ", "TOML"}, [&] { read("[defaults]\nlobes = = 3\n"); });
  expect_error(ErrorCode::kInput, {folder_ / "none.toml", "read", "docs/reference/manifests.md"},
               [&] { read_bake_manifest(folder_ / "none.toml", pattern_); });
}

TEST_F(BakeManifestTest, WrongTypesAndRanges) {
  const auto refused = [&](const std::string& to, std::vector<std::string> parts) {
    parts.front() = "map." + parts.front();
    expect_refused("lobes = 2", to, parts);
  };
  refused("lobes = 9", {"lobes", "9", "1 to 8"});
  refused("lobes = 0", {"lobes", "0"});
  refused("lobes = \"4\"", {"lobes", "\"4\"", "an integer"});
  refused("iterations = 1001", {"iterations", "1001", "1 to 1000"});
  refused("passes = 2.5", {"passes", "2.5", "1 to 8"});
  refused("first_level = 16", {"first_level", "16", "0 to 15"});
  refused("align = -1", {"align", "-1", "0 to 10"});
  refused("kappa_cap = 0.5", {"kappa_cap", "0.5", "1 to 100000"});
  refused("reference = 1", {"reference", "1", "true or false"});
  refused("no_start_search = \"yes\"", {"no_start_search", "\"yes\"", "true or false"});
  refused("checknan = 1", {"checknan", "1", "true or false"});
  refused("two_channel = 1", {"two_channel", "1", "true or false"});
  refused("order = \"color\"", {"order", "\"color\"", "colour, scanline"});
  refused("order = 1", {"order", "1", "string"});
  refused("coarse_normals = \"some\"", {"coarse_normals", "\"some\"", "binned, all"});
  refused("data_format = \"double\"", {"data_format", "\"double\"", "snorm16, half, float"});
  refused("compression = \"zip:0\"", {"compression", "\"zip:0\"", "none|rle|piz|zip[:1-9]"});
  for (const char* key : {"wrap", "swrap", "twrap"})
    refused(std::string(key) + " = \"wall\"", {key, "\"wall\"", "black, clamp, periodic, mirror"});
  refused("green = \"left\"", {"green", "\"left\"", "up, down"});
  refused("bumpformat = \"depth\"", {"bumpformat", "\"depth\"", "auto, height, normal"});
  refused("fixnan = \"box5\"", {"fixnan", "\"box5\"", "none, black, box3"});
  refused("height_scale = 0", {"height_scale", "0", "a number other than 0"});
  refused("height_scale = inf", {"height_scale", "inf"});
  refused("height_scale = 1e39", {"height_scale", "1e+39"});
  refused("repair_max = 1.5", {"repair_max", "1.5", "0 to 1"});
  expect_refused("albedo = \"\"", "albedo = 3", {"map.albedo", "3", "string"});
  expect_refused("unsigned = true", "unsigned = true\nsigned = true", {"map.unsigned", "signed", "expected only one"});
  for (const char* value : {"0", "-0.1", "inf", "nan", "\"small\""})
    expect_refused("error_max = 0.25", std::string("error_max = ") + value, {"map.error_max", "above 0"});
  expect_refused("lobes = 3", "lobes = 12", {"defaults.lobes", "12"});
  expect_refused("input = \"a.png\"", "input = \"\"", {"map.input", "\"\"", "string"});
  expect_refused("input = \"a.png\"", "input = [\"a.png\"]", {"map.input", "an array of 1", "string"});
}

TEST_F(BakeManifestTest, FilesMustBeApart) {
  for (const char* name : {"out/a.ndf.exr", "./out/../out/a.ndf.exr"})
    expect_refused("output = \"out/b.exr\"", std::string("output = \"") + name + '"',
                   {"map.output", "\"out/a.ndf.exr\"", "a.png", "already"});
  std::filesystem::create_directory(folder_ / "out");
  std::filesystem::create_directory_symlink(folder_ / "out", folder_ / "other");
  expect_refused("output = \"out/b.exr\"", "output = \"other/a.ndf.exr\"", {"map.output", "already"});
  const auto refused = [&](const std::string& text, const std::string& line, std::vector<std::string> parts) {
    parts.push_back(path() + ":" + line + ": ");
    expect_error(ErrorCode::kInput, parts, [&] { read(text); });
  };
  const std::string later = "\n[[map]]\ninput = \"a.exr\"\noutput = \"b.exr\"\n";
  refused("[[map]]\ninput = \"c.exr\"\noutput = \"a.exr\"\n" + later, "3", {"map.output", "\"a.exr\"", "read"});
  refused("[[map]]\ninput = \"a.exr\"\noutput = \"a.exr\"\n", "3", {"map.output", "\"a.exr\"", "read"});
  refused("[[map]]\ninput = \"a.png\"\nalbedo = \"c.exr\"\noutput = \"c.exr\"\n", "4",
          {"map.output", "\"c.exr\"", "read"});
}

TEST_F(BakeManifestTest, OutputsMustBeNamesOfBakedFiles) {
  expect_refused("output = \"out/b.exr\"", "output = \"out/b.png\"", {"map.output", "ends in .ndf.exr or .exr"});
  std::filesystem::create_directory(folder_ / "out");
  expect_refused("output = \"out/b.exr\"", "output = \"out\"", {"map.output", "name that ends in"});
}

// The settings of a single map override the settings for all maps.
TEST_F(BakeManifestTest, SettingsMayBeChosenForATarget) {
  const auto of_map = [&](const std::string& defaults, const std::string& map) {
    return read("[defaults]\n" + defaults + "\n[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\n" + map)[0];
  };
  const ManifestMap chosen = of_map("target_error = 0.2\nbrdf = \"ggx:0.4\"", "ndf = \"vmf\"\nbest_effort = true");
  ASSERT_TRUE(chosen.target);
  EXPECT_EQ(chosen.target->error, 0.2);
  EXPECT_EQ(chosen.target->brdf.id.text(), "ggx:0.4");
  EXPECT_EQ(chosen.target->only, Representation::kMovmf);
  EXPECT_TRUE(chosen.target->best_effort);
  const ManifestMap timed = of_map("error_max = 1\nlobes = 3", "budget_ms = 500");
  EXPECT_EQ(timed.target->seconds, 0.5);
  EXPECT_EQ(timed.job.fitting.lobe_count, MovmfSettings().lobe_count);
  const ManifestMap plain = of_map("target_error = 0.2", "lobes = 3");
  EXPECT_FALSE(plain.target);
  EXPECT_EQ(plain.job.fitting.lobe_count, 3);
  const auto refused = [&](const std::string& map, const std::string& line, std::vector<std::string> parts) {
    parts.push_back(path() + ":" + line + ": ");
    expect_error(ErrorCode::kInput, parts, [&] { of_map("", map); });
  };
  refused("target_error = 0.1\nsh_order = 3\nndf = \"sh\"", "7",
          {"map.sh_order", "are mutually exclusive", "target_error"});
  refused("target_error = 0.1\nbudget_ms = 5", "7", {"map.budget_ms", "together with", "target_error"});
  refused("target_error = 0", "6", {"map.target_error", "0"});
  refused("brdf = \"lambert\"", "6", {"map.brdf", "target_error", "budget_ms", "neither"});
  refused("target_error = 0.1\nbrdf = \"phong:3\"", "7", {"map.brdf", "phong:3"});
  refused("target_error = 0.1\nbrdf = \"ggx:0.4\"\nndf = \"gmm\"", "3", {"cannot shade"});
}

TEST_F(BakeManifestTest, ATileIsAMap) {
  for (const char* name : {"rock_1001.png", "rock_1012.png", "rock_x.png"}) write_bytes(folder_ / name, "");
  const std::string set = "[[map]]\ninput = \"rock_<UDIM>.png\"\nalbedo = \"c_<UDIM>.png\"\n";
  std::vector<ManifestMap> maps = read(set + "output = \"out/<UDIM>.exr\"\nerror_max = 0.5");
  ASSERT_EQ(maps.size(), 2u);
  EXPECT_EQ(maps[1].name, "out/1012.exr");
  EXPECT_EQ(maps[1].job.input, folder_ / "rock_1012.png");
  EXPECT_EQ(maps[1].job.albedo, folder_ / "c_1012.png");
  EXPECT_EQ(maps[1].error_max, 0.5);
  const auto refused = [&](const std::string& text, const std::string& line, std::vector<std::string> parts) {
    parts.push_back(path() + ":" + line + ": ");
    expect_error(ErrorCode::kInput, parts, [&] { read(text); });
  };
  refused(set + "output = \"out\"\n", "4", {"map.output", "several maps"});
  std::filesystem::create_directory(folder_ / "out");
  EXPECT_EQ(read(set + "output = \"out\"\n")[0].name, "out/rock_1001.ndf.exr");
  refused(set + "output = \"out/<UDIM>.exr\"\n[[map]]\ninput = \"a.png\"\noutput = \"out/1012.exr\"\n", "7",
          {folder_ / "rock_1012.png", "already"});
  refused("[[map]]\ninput = \"<UDIM>/a.png\"\noutput = \"<UDIM>.exr\"\n", "2", {"map.input", "folder"});
  refused("[[map]]\ninput = \"a.png\"\noutput = \"<UDIM>.exr\"\n", "3", {"map.output", "without <UDIM>"});
  refused("[[map]]\ninput = \"a.png\"\noutput = \"a.exr\"\nalbedo = \"<UDIM>.png\"\n", "4",
          {"map.albedo", "without <UDIM>"});
}

TEST_F(BakeManifestTest, ASetWithoutTilesIsAMapThatNobodyFinds) {
  const std::vector<ManifestMap> maps = read("[[map]]\ninput = \"none_<UDIM>.png\"\noutput = \"<UDIM>.exr\"\n");
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].job.input, folder_ / "none_<UDIM>.png");
}

TEST_F(BakeManifestTest, TheDocumentedExampleIsRead) {
  const std::string page = read_bytes(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/manifests.md");
  const std::size_t begin = page.find("```toml\n") + 8;
  const std::vector<ManifestMap> maps = read(page.substr(begin, page.find("```", begin) - begin));
  ASSERT_EQ(maps.size(), 3u);
  EXPECT_EQ(maps[0].job.fitting.lobe_count, 4);
  EXPECT_EQ(maps[0].job.albedo, folder_ / "source/bricks_albedo.png");
  EXPECT_EQ(maps[0].error_max, 0.95);
  EXPECT_EQ(maps[1].job.fitting.lobe_count, 2);
  EXPECT_EQ(maps[1].job.reading.height_scale, 8.0f);
  EXPECT_EQ(maps[1].job.reading.wrap_t, WrapMode::kClamp);
  EXPECT_FALSE(maps[1].job.reading.green) << "a copied example must not set what may be wrong";
  EXPECT_EQ(maps[2].error_max, 0.95);
}

// For every key that the program reads, the page has a row with the key in backquotes.
TEST_F(BakeManifestTest, EveryKeyIsDocumented) {
  const std::string page = read_bytes(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/manifests.md");
  std::vector<std::string> keys = bake_parameters().names(kInManifest);
  keys.emplace_back("output");
  for (const std::string& key : keys) EXPECT_NE(page.find("`" + key + "`"), std::string::npos) << key;
}

}  // namespace
}  // namespace multum::testing
