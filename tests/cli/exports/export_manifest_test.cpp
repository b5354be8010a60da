// SPDX-License-Identifier: Apache-2.0
// Tests multum export of several maps: output names, tile sets, and manifests. An export with a manifest skips
// unchanged maps.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tools/multum/compared_bake.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class ExportManifestTest : public CliTest {
 protected:
  void SetUp() override {
    for (const char* name : {"rock_1001.png", "rock_1003.png", "wall.png"})
      write_test_image(path(name), normal_image(16, 16));
    write_test_image(path("orm_1001.png"), normal_image(16, 16));
    write_test_image(path("orm_1003.png"), normal_image(16, 16));
  }
  void write_manifest(const std::string& text) const { std::ofstream(path("maps.toml")) << text; }
  ProgramResult run_manifest(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"export", "--manifest", path("maps.toml")});
    return multum(more);
  }
  std::set<std::string> names_in(const std::string& folder) const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(path(folder))) names.insert(entry.path().filename().string());
    return names;
  }
};

constexpr char kTwoMaps[] =
    "[defaults]\nbumpformat = \"normal\"\ngreen = \"up\"\nformat = \"ktx2\"\n"
    "[[map]]\ninput = \"rock_<UDIM>.png\"\noutput = \"out/rock_<UDIM>.ktx2\"\nroughness = \"orm_<UDIM>.png\"\n"
    "[[map]]\ninput = \"wall.png\"\noutput = \"out/wall\"\nbase_roughness = 0.3\nformat = \"png\"\n";

// The maps have the same content, so their counts equal the counts of a single export.
TEST_F(ExportManifestTest, EachReportCountsItsOwnLaunches) {
  fs::create_directory(path("out"));
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "export");
    words.insert(words.end(), {"--bumpformat", "normal", "--green", "up"});
    const ProgramResult result = multum(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  };
  const auto launches = [&](const std::string& report) {
    return nlohmann::json::parse(read_bytes(path(report))).at("launches");
  };
  run({path("wall.png"), "-o", path("alone"), "--report", path("alone.json")});
  EXPECT_GT(launches("alone.json").at("one_lobe_fit"), 0);
  run({path("rock_1001.png"), path("rock_1003.png"), path("wall.png"), "-o", path("out"), "--report", path("out")});
  for (const char* report : {"out/rock_1001.json", "out/rock_1003.json", "out/wall.json"})
    EXPECT_EQ(launches(report), launches("alone.json")) << report;
}

TEST(ComparedBakeJob, HasTheMemoryAndTheFolderOfItsExport) {
  ExportJob job;
  job.input = "map.png";
  job.memory_bytes = 100 << 20;
  job.scratch_folder = "/elsewhere";
  job.threads = 3;
  const BakeJob bake = compared_bake_job(job, "lobes.ndf.exr");
  EXPECT_EQ(bake.memory_bytes, resident_memory_of(100 << 20));
  EXPECT_EQ(bake.scratch_folder, "/elsewhere");
  EXPECT_EQ(bake.threads, 3);
  EXPECT_EQ(compared_bake_job(ExportJob{}, "").memory_bytes, resident_memory_of(256 << 20)) << "the default";
}

TEST_F(ExportManifestTest, SetsAndSeveralMaps) {
  fs::create_directory(path("out"));
  const std::vector<std::string> reading = {"--bumpformat", "normal", "--green", "up", "--no-measure"};
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "export");
    words.insert(words.end(), reading.begin(), reading.end());
    return multum(words);
  };
  ASSERT_EQ(
      run({path("rock_<UDIM>.png"), "-o", path("set_<UDIM>.dds"), "--roughness", path("orm_<UDIM>.png")}).exit_code, 0);
  for (const char* file : {"set_1001_normal.dds", "set_1003_orm.dds"}) EXPECT_TRUE(fs::exists(path(file))) << file;
  ASSERT_EQ(run({path("rock_<UDIM>.png"), path("wall.png"), "-o", path("out"), "--format", "ktx2"}).exit_code, 0);
  EXPECT_EQ(names_in("out"),
            (std::set<std::string>{"rock_1001_normal.ktx2", "rock_1001_orm.ktx2", "rock_1003_normal.ktx2",
                                   "rock_1003_orm.ktx2", "wall_normal.ktx2", "wall_orm.ktx2"}));
  fs::remove_all(path("out"));
  fs::create_directory(path("out"));
  // A map that fails does not stop the export of the others.
  std::ofstream(path("bad.png")) << "no image";
  const ProgramResult result = run({path("bad.png"), path("wall.png"), "-o", path("out")});
  EXPECT_EQ(result.exit_code, kInput);
  expect_says(result.err, {"bad.png", "1 exported, 1 failed"});
  EXPECT_TRUE(fs::exists(path("out/wall/normal_04.png")));
  ASSERT_EQ(run({path("rock_<UDIM>.png"), "-o", path("out"), "--shard", "2/2"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(path("out/rock_1003")));
  EXPECT_FALSE(fs::exists(path("out/rock_1001")));
  expect_refusal(run({path("none_<UDIM>.png"), "-o", path("out")}), kInput, {"none_1001.png"});
  expect_refusal(run({path("wall.png"), path("rock_1001.png"), "-o", path("one.ktx2")}), kUsage,
                 {"one.ktx2", "<UDIM>"});
  expect_refusal(run({path("wall.png"), path("wall.png"), "-o", path("out")}), kUsage, {"wall", "both"});
  expect_refusal(run({path("wall.png"), "-o", path("out"), "--shard", "1/2"}), kUsage, {"--shard"});
}

TEST_F(ExportManifestTest, ExportsWhatHasChanged) {
  write_manifest(kTwoMaps);
  const ProgramResult first = run_manifest();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  expect_says(first.out, {"3 maps: 3 exported, 0 unchanged, 0 failed"});
  EXPECT_TRUE(fs::exists(path("out/rock_1003_orm.ktx2")));
  EXPECT_TRUE(fs::exists(path("out/wall/orm_04.png")));
  expect_says(run_manifest({"--check"}).out, {"0 exported, 3 unchanged"});

  // A changed setting, a changed source, a missing file and an edited file are each found and named.
  std::string text = kTwoMaps;
  text.replace(text.find("0.3"), 3, "0.4");
  write_manifest(text);
  write_test_image(path("orm_1001.png"), normal_image(16, 16, false, -1.0));
  fs::remove(path("out/rock_1003_normal.ktx2"));
  const ProgramResult dry = run_manifest({"--check", "--dry-run"});
  EXPECT_EQ(dry.exit_code, kVerification);
  expect_says(dry.err, {"rock_1001.ktx2: stale", "inputs", "rock_1003.ktx2: missing", "out/wall: stale", "lobe"});
  EXPECT_FALSE(fs::exists(path("out/rock_1003_normal.ktx2")));
  EXPECT_EQ(run_manifest({"--check"}).exit_code, kVerification);
  EXPECT_EQ(run_manifest({"--check"}).exit_code, 0);
  std::ofstream(path("out/wall/normal_02.png")) << "not that";
  const ProgramResult damaged = run_manifest({"--check"});
  EXPECT_EQ(damaged.exit_code, kVerification);
  expect_says(damaged.err, {"out/wall: damaged", "normal_02.png", "exported now"});
  EXPECT_EQ(run_manifest({"--check"}).exit_code, 0);

  // An unreadable map does not stop the export of the others.
  std::ofstream(path("wall.png")) << "no image";
  fs::remove(path("out/rock_1001_orm.ktx2"));
  const ProgramResult broken = run_manifest();
  EXPECT_EQ(broken.exit_code, kInput);
  expect_says(broken.err, {"wall.png", "1 exported, 1 unchanged, 1 failed"});
}

TEST_F(ExportManifestTest, RefusesWhatIsWrongWithItsLine) {
  const auto refused = [&](const std::string& text, const std::vector<std::string>& parts) {
    write_manifest(text);
    expect_refusal(run_manifest(), kInput, parts);
  };
  const std::string map = "[[map]]\ninput = \"wall.png\"\n";
  refused("[[map]]\noutput = \"out\"\n", {"maps.toml:1", "input"});
  refused(map + "output = \"out\"\nbase_roughnes = 0.2\n", {"maps.toml:4", "base_roughnes", "base_roughness"});
  refused(map + "output = \"out\"\nbase_roughness = 2\n", {"maps.toml:4", "0 to 1"});
  refused(map + "output = \"out.png\"\n", {"maps.toml:3", "out.png", "NAME.ktx2"});
  refused(map + "output = \"out_<UDIM>\"\n", {"maps.toml:3", "<UDIM>"});
  refused("[[map]]\ninput = \"rock_<UDIM>.png\"\noutput = \"out\"\n", {"maps.toml:3", "a set"});
  refused(map + "output = \"out\"\n" + map + "output = \"out/../out\"\n",
          {"maps.toml:6", "already the output of ", "wall.png"});
  refused(map + "output = \"out\"\nlobes_per_texel = 1\n", {"maps.toml:4"});
  write_manifest(kTwoMaps);
  expect_refusal(multum({"export", path("wall.png"), "-o", path("out"), "--manifest", path("maps.toml")}), kUsage,
                 {"--manifest"});
  expect_refusal(run_manifest({"--base-roughness", "0.2"}), kUsage, {"--base-roughness", "[defaults]"});
  expect_refusal(multum({"export", path("wall.png"), "-o", path("out"), "--check"}), kUsage, {"--check"});
}

}  // namespace
}  // namespace multum::testing
