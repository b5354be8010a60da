// SPDX-License-Identifier: Apache-2.0
// Tests the output path of each map in a run.
#include "host/bakes/bake/bake_batch.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

class BakeBatchTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  void make(const std::vector<std::string>& names) {
    for (const std::string& name : names) write_bytes(path(name), "");
  }
  std::vector<std::string> outputs(std::vector<std::string> inputs) {
    for (std::string& input : inputs) input = path(input);
    std::vector<std::string> found;
    for (const BakeJob& job : make_bake_jobs(pattern_, inputs)) found.push_back(job.output);
    return found;
  }
  void expect_refused(const std::vector<std::string>& inputs, ErrorCode code, const std::vector<std::string>& parts) {
    expect_error(code, parts, [&] { outputs(inputs); });
  }

  TemporaryFolder folder_;
  BakeJob pattern_;
};

TEST_F(BakeBatchTest, OneMapIsThePattern) {
  pattern_.output = path("a.ndf.exr");
  pattern_.report = path("r.json");
  EXPECT_EQ(outputs({"a.png"}), std::vector<std::string>{path("a.ndf.exr")});
}

TEST_F(BakeBatchTest, SeveralMapsGoToAFolderUnderTheirNames) {
  std::filesystem::create_directory(path("out"));
  pattern_.output = path("out");
  EXPECT_EQ(outputs({"b.png", "a.b.tif"}), (std::vector<std::string>{path("out/b.ndf.exr"), path("out/a.b.ndf.exr")}));
  expect_refused({"b.png", "b.tif"}, ErrorCode::kUsage, {"would be written there"});
  pattern_.report = path("r.json");
  expect_refused({"b.png", "a.png"}, ErrorCode::kUsage, {"r.json: ", "several maps"});
  pattern_.output = path("one.ndf.exr");
  expect_refused({"b.png", "a.png"}, ErrorCode::kUsage, {"one.ndf.exr: ", "several maps"});
}

TEST_F(BakeBatchTest, SetsAreFoundByTheirTiles) {
  make({"rock_1002.png", "rock_1001.png", "rock_1011.png", "rock_0999.png", "rock_1000.png", "rock_10021.png",
        "rock_1003.jpg", "rock_100a.png", "stone_1001.png"});
  pattern_.output = path("rock_<UDIM>.ndf.exr");
  pattern_.albedo = "colour.<UDIM>.png";
  pattern_.report = path("<UDIM>.json");
  const std::vector<BakeJob> jobs = make_bake_jobs(pattern_, {path("rock_<UDIM>.png")});
  ASSERT_EQ(jobs.size(), 3u);
  EXPECT_EQ(jobs[0].input, path("rock_1001.png"));
  EXPECT_EQ(jobs[1].output, path("rock_1002.ndf.exr"));
  EXPECT_EQ(jobs[2].input, path("rock_1011.png"));
  EXPECT_EQ(jobs[2].albedo, "colour.1011.png");
  EXPECT_EQ(jobs[2].report, path("1011.json"));
  expect_refused({"none_<UDIM>.png"}, ErrorCode::kInput, {"none_1001.png"});
  expect_refused({"rock_<UDIM>.png", "b.png"}, ErrorCode::kUsage, {"b.png", "not a set"});
  expect_refused({"rock_<UDIM>.png", "rock_<UDIM>.png"}, ErrorCode::kUsage, {"would be written there"});
}

TEST_F(BakeBatchTest, SetsHaveTheWordsOfOtherPrograms) {
  make({"rock_1002.png", "rock_1013.png", "wall_u1_v1.png", "wall_u3_v2.png", "wall_u0_v1.png", "wall_u11_v1.png",
        "wall_u1_v1_old.png", "wall_u01_v1.png"});
  for (const char* word : {"<UDIM>", "<udim>", "%(UDIM)d"}) {
    pattern_.output = path(std::string("o_") + word + ".exr");
    const std::vector<BakeJob> jobs = make_bake_jobs(pattern_, {path(std::string("rock_") + word + ".png")});
    ASSERT_EQ(jobs.size(), 2u) << word;
    EXPECT_EQ(jobs[1].input, path("rock_1013.png"));
    EXPECT_EQ(jobs[1].output, path("o_1013.exr"));
    EXPECT_NE(jobs[0].reading.tiles, nullptr);
    EXPECT_EQ(jobs[0].reading.tiles, jobs[1].reading.tiles);
  }
  for (const char* word : {"<UVTILE>", "<uvtile>"}) {
    pattern_.output = path("o_<UDIM>.exr");
    const std::vector<BakeJob> jobs = make_bake_jobs(pattern_, {path(std::string("wall_") + word + ".png")});
    ASSERT_EQ(jobs.size(), 2u) << word;
    EXPECT_EQ(jobs[0].input, path("wall_u1_v1.png"));
    EXPECT_EQ(jobs[1].input, path("wall_u3_v2.png"));
    EXPECT_EQ(jobs[0].output, path("o_1001.exr"));
    EXPECT_EQ(jobs[1].output, path("o_1013.exr"));
    EXPECT_EQ(jobs[1].reading.tile, "1013");
  }
}

}  // namespace
}  // namespace multum::testing
