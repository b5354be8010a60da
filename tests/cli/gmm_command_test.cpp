// SPDX-License-Identifier: Apache-2.0
// Tests multum bake --ndf gmm: the file, the reported errors, the refusals, and what it has in common with bakes of vMF
// lobes.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class GmmCommandTest : public CliTest {
 protected:
  ProgramResult bake(const std::string& input, const std::string& output, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"bake", "--ndf", "gmm", path(input), "-o", path(output)});
    return multum(more);
  }
  std::string hash(const std::string& name) const { return read_baked_header(path(name)).provenance.content_hash; }
};

TEST_F(GmmCommandTest, BakesVerifiesAndSaysWhatItHolds) {
  make_map("map", 64);
  const ProgramResult result = bake("map_normal.png", "map.ndf.exr",
                                    {"--albedo", path("map_albedo.png"), "--report", path("map.json"), "--lobes", "3"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto report = nlohmann::json::parse(read_bytes(path("map.json")));
  EXPECT_EQ(report["counts"]["nonfinite"], 0);
  EXPECT_GT(report["launches"]["movmf_em_texels"], 0);
  // Each of the 7 levels has the errors of 4 BRDFs, with and without colours, at 4 points. Only the last level has a
  // single point.
  EXPECT_EQ(report["measured_error"].size(), (6u * 4u + 1u) * 8u);
  for (const auto& row : report["measured_error"]) EXPECT_LT(row["relative_l1"].get<double>(), 1.0) << row.dump();
  const ProgramResult info = multum({"info", path("map.ndf.exr")});
  for (const char* line :
       {"representation  gmm: 3 planar Gaussians per texel, with a colour each", "64 x 64, 7 levels",
        "encoding        snorm16; keeps variances down to 3.3e-05", "\"representation\":\"gmm\"", "\"lobes\":3"})
    EXPECT_TRUE(contains(info.out, line)) << line << " is not in\n" << info.out;
  const ProgramResult verify = multum({"verify", path("map.ndf.exr")});
  EXPECT_EQ(verify.exit_code, 0) << verify.out;
  for (const char* check : {"|mean| <= 1", "variance"}) EXPECT_TRUE(contains(verify.out, check)) << verify.out;
}

TEST_F(GmmCommandTest, ThreadsMemoryAndScalarKernelsChangeNoByte) {
  TestImage image = normal_image(150, 91);
  image.type = OIIO::TypeDesc::UINT16;
  write_test_image(path("map.png"), image);
  const std::vector<std::string> quick = {"--no-measure", "--no-start-search", "--lobes", "2"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), quick.begin(), quick.end());
    return more;
  };
  ASSERT_EQ(bake("map.png", "a.ndf.exr", with({"--threads", "2"})).exit_code, 0);
  ASSERT_EQ(bake("map.png", "b.ndf.exr", with({"--threads", "1", "--memory", "289M"})).exit_code, 0);
  ASSERT_EQ(bake("map.png", "c.ndf.exr", with({"--scalar"})).exit_code, 0);
  const std::string bytes = read_bytes(path("a.ndf.exr"));
  EXPECT_EQ(read_bytes(path("b.ndf.exr")), bytes);
  EXPECT_EQ(read_bytes(path("c.ndf.exr")), bytes);
}

// Baking a region of an unchanged map gives the same file, except that EM improves the fits a little. A file of vMF
// lobes is refused.
TEST_F(GmmCommandTest, ARegionGoesOntoGaussiansAlone) {
  make_map("map", 64);
  const std::vector<std::string> quick = {"--no-measure", "--no-start-search"};
  ASSERT_EQ(bake("map_normal.png", "old.ndf.exr", quick).exit_code, 0);
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("lobes.ndf.exr"), "--no-measure", "--no-start-search"})
                .exit_code,
            0);
  const ProgramResult region =
      bake("map_normal.png", "new.ndf.exr", {"--no-measure", "--region", "8,8,16,16", "--onto", path("old.ndf.exr")});
  ASSERT_EQ(region.exit_code, 0) << region.err;
  EXPECT_EQ(multum({"verify", path("new.ndf.exr")}).exit_code, 0);
  const MovmfMipmap old = read_movmf_mipmap(path("old.ndf.exr")), now = read_movmf_mipmap(path("new.ndf.exr"));
  EXPECT_EQ(old.levels[1].lobes[0].back(), now.levels[1].lobes[0].back()) << "outside of the region";
  double most = 0.0;  // the largest change of the coarsest level's mean normal, which covers the region
  for (std::size_t k = 0; k < 2; ++k) {
    double change = 0.0;
    for (std::size_t j = 0; j < old.levels.back().lobes.size(); ++j)
      change += static_cast<double>(now.levels.back().lobes[j][0][static_cast<int>(k)] -
                                    old.levels.back().lobes[j][0][static_cast<int>(k)]);
    most = std::max(most, std::abs(change));
  }
  EXPECT_LT(most, 1e-3);
  const ProgramResult refused =
      bake("map_normal.png", "bad.ndf.exr", {"--no-measure", "--region", "8,8,16,16", "--onto", path("lobes.ndf.exr")});
  expect_refusal(refused, kInput, {"lobes.ndf.exr", "representation movmf", "expected gmm"});
}

TEST_F(GmmCommandTest, AManifestBakesAndChecksIt) {
  make_map("map", 32);
  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"map_normal.png\"\noutput = \"gmm.ndf.exr\"\nndf = \"gmm\"\nlobes = 2\n");
  ASSERT_EQ(multum({"bake", "--manifest", path("maps.toml")}).exit_code, 0);
  EXPECT_EQ(read_baked_header(path("gmm.ndf.exr")).representation, Representation::kGmm);
  const ProgramResult check = multum({"bake", "--manifest", path("maps.toml"), "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  EXPECT_TRUE(contains(bake("map_normal.png", "gmm.ndf.exr", {"--lobes", "2"}).out, "unchanged"));
  const std::string first = hash("gmm.ndf.exr");
  ASSERT_EQ(bake("map_normal.png", "gmm.ndf.exr", {"--lobes", "1"}).exit_code, 0);
  EXPECT_NE(hash("gmm.ndf.exr"), first);
}

}  // namespace
}  // namespace multum::testing
