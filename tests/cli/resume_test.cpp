// SPDX-License-Identifier: Apache-2.0
// Tests bakes that continue: after a kill with --resume, and after an edit with --region and --onto.
#include <fmt/format.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/bakes/movmf/row_records.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

#include "host/formats/image/files/png_writer.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/foundation/base/files/work_folder.h"
#include "tests/cli/program.h"
#include "tests/fixtures/test_maps.h"

namespace multum::testing {
namespace {

class ResumeTest : public CliTest {
 protected:
  std::vector<std::string> command(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"bake",   path("map_normal.png"), "-o", path("map.ndf.exr"), "--no-measure",
                                          "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum_command(arguments);
  }
  std::string partial() const { return path(".multum-partial-map.ndf.exr"); }
  // Holds the records of finished rows, and the offset of these rows in the file.
  struct Kept {
    RowBlock rows;
    std::uint64_t begin;
  };
  static std::vector<Kept> kept_rows(const std::string& partial) {
    std::vector<Kept> found;
    const std::string path = partial + "/progress";
    if (!std::filesystem::exists(path)) return found;
    const RecordFile file(path);
    file.visit_records(nullptr, [&](const RecordFile::Place& place) {
      Kept kept{{}, place.offset + sizeof(RowBlock)};
      found.push_back(kept);
      return file.read(place.offset, {reinterpret_cast<std::uint8_t*>(&found.back().rows), sizeof(RowBlock)});
    });
    return found;
  }
  static bool has_rows(const std::string& partial, int level) {
    for (const Kept& kept : kept_rows(partial))
      if (kept.rows.level == level) return true;
    return false;
  }
  // Waits until some rows of a level are done.
  static void wait_for_rows(Program& bake, const std::string& partial, int level) {
    while (bake.running() && !has_rows(partial, level)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  // Kills a bake while it fits the finest level.
  void kill_a_bake(const std::vector<std::string>& more) const {
    std::vector<std::string> options = more;
    options.push_back("--resume");
    Program bake(command(options));
    wait_for_rows(bake, partial(), 2);
    bake.send(SIGKILL);
    ASSERT_EQ(bake.wait().signal, SIGKILL) << "the bake ended before the kill";
    ASSERT_GT(kept_rows(partial()).size(), 0u);
  }
  std::uint64_t rows_resumed() const {
    std::ifstream in(path("report.json"));
    return nlohmann::json::parse(in).at("rows_resumed").get<std::uint64_t>();
  }
  std::string content_hash() const { return read_movmf_header(path("map.ndf.exr")).header.provenance.content_hash; }
};

TEST_F(ResumeTest, AKilledBakeGoesOnFromItsFinishedRows) {
  make_map("map", 512);
  for (const std::vector<std::string>& options : {std::vector<std::string>{},
                                                  {"--albedo", path("map_albedo.png"), "--lobes", "2"},
                                                  {"--first-level", "1"},
                                                  {"--refine"}}) {
    ASSERT_EQ(run_program(command(options)).exit_code, 0);
    const std::string whole = content_hash();
    std::filesystem::remove(path("map.ndf.exr"));
    kill_a_bake(options);
    EXPECT_FALSE(std::filesystem::exists(path("map.ndf.exr")));
    std::vector<std::string> again = options;
    again.insert(again.end(), {"--resume", "--report", path("report.json")});
    const ProgramResult resumed = run_program(command(again));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_GT(rows_resumed(), 100u);
    EXPECT_EQ(content_hash(), whole) << "pixels differ from those of an undisturbed bake";
    EXPECT_FALSE(std::filesystem::exists(partial()));
    std::filesystem::remove(path("map.ndf.exr"));
  }
}

TEST_F(ResumeTest, DamagedRowsAreFittedAgain) {
  make_map("map", 512);
  for (const auto& [options, level] :
       std::vector<std::pair<std::vector<std::string>, int>>{{{}, 2}, {{"--refine"}, 4}}) {
    ASSERT_EQ(run_program(command(options)).exit_code, 0);
    const std::string whole = content_hash();
    std::filesystem::remove(path("map.ndf.exr"));
    kill_a_bake(options);
    std::uint64_t begin = 0;
    for (const Kept& kept : kept_rows(partial()))
      if (kept.rows.level == level && begin == 0)
        begin = kept.begin + (level == 4 ? kept.rows.row_bytes[0] * static_cast<unsigned>(kept.rows.row_count) : 0);
    ASSERT_GT(begin, 0u);
    {
      std::fstream file(partial() + "/progress", std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<std::streamoff>(begin) + 1000);
      file << "no lobes";
    }
    std::ofstream(partial() + "/progress", std::ios::app) << "half a record";
    std::vector<std::string> again = options;
    again.emplace_back("--resume");
    ASSERT_EQ(run_program(command(again)).exit_code, 0);
    EXPECT_EQ(content_hash(), whole);
    std::filesystem::remove(path("map.ndf.exr"));
  }
}

// A farm sends SIGTERM before it kills a program (docs/reference/exit_codes.md).
TEST_F(ResumeTest, ATerminatedBakeLeavesWhatResumeTakes) {
  make_map("map", 512);
  const auto bake = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum_command(arguments);
  };
  // A bake with a target writes its rows next to the output, under a name of its own.
  for (const auto& [options, name] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--no-measure", "--refine"}, "map.ndf.exr"},
           {{"--no-measure", "--ndf", "gmm"}, "map.ndf.exr"},
           {{"--target-error", "0.3", "--ndf", "vmf"}, "map.ndf.exr/.multum-partial-chosen.exr"}}) {
    ASSERT_EQ(run_program(bake(options)).exit_code, 0);
    const std::string whole = content_hash();
    std::filesystem::remove(path("map.ndf.exr"));
    std::vector<std::string> with_resume = options;
    with_resume.emplace_back("--resume");
    Program stopped(bake(with_resume));
    wait_for_rows(stopped, path(".multum-partial-" + name), 2);
    const auto asked = std::chrono::steady_clock::now();
    stopped.send(SIGTERM);
    EXPECT_EQ(stopped.wait().exit_code, 130) << name << ": it ended before the signal";
    EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(30));
    EXPECT_FALSE(std::filesystem::exists(path("map.ndf.exr")));
    with_resume.insert(with_resume.end(), {"--report", path("report.json")});
    const ProgramResult resumed = run_program(bake(with_resume));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_GT(rows_resumed(), 100u) << name;
    EXPECT_EQ(content_hash(), whole) << name;
    for (const std::string& left : folder_.names()) EXPECT_FALSE(left.starts_with(".multum-")) << left;
    std::filesystem::remove(path("map.ndf.exr"));
  }
}

// If a scene has a target, the trials are repeated, and the bake continues.
TEST_F(ResumeTest, ATerminatedSceneGoesOn) {
  make_map("map", 512);
  std::ofstream(path("scene.toml")) << "[camera]\nresolution = [96, 72]\n[budget]\ntarget_error = 0.3\n"
                                       "[[map]]\nname = \"wall\"\nnormal = \"map_normal.png\"\n[[material]]\n"
                                       "name = \"paint\"\nbrdf = \"blinn-phong\"\nexponent = 100\n[[object]]\n"
                                       "name = \"front\"\nmap = \"wall\"\nmaterial = \"paint\"\nwidth = 2.0\n"
                                       "distance = [0.4, 20]\n[[light]]\ndirection = [0.3, 0.8, 0.5]\n";
  const std::vector<std::string> scene =
      multum_command({"bake", path("scene.toml"), "-o", path("out"), "--quiet", "--resume"});
  ASSERT_EQ(run_program(scene).exit_code, 0);
  const std::string file = path("out/wall.ndf.exr");
  const std::string whole = read_movmf_header(file).header.provenance.content_hash;
  std::filesystem::remove_all(path("out"));
  Program stopped(scene);
  const std::string partial_of_scene = path("out/.multum-partial-wall.ndf.exr/.multum-partial-chosen.exr");
  wait_for_rows(stopped, partial_of_scene, 2);
  stopped.send(SIGTERM);
  EXPECT_EQ(stopped.wait().exit_code, 130) << "the bake ended before the signal";
  EXPECT_FALSE(std::filesystem::exists(file));
  ASSERT_TRUE(has_rows(partial_of_scene, 2));
  ASSERT_EQ(run_program(scene).exit_code, 0);
  EXPECT_EQ(read_movmf_header(file).header.provenance.content_hash, whole);
  std::ifstream in(path("out/report.json"));
  EXPECT_GT(nlohmann::json::parse(in).at("maps").at(0).at("bake").at("rows_resumed").get<int>(), 100);
}

// Finished maps are kept, and the bake of the stopped map continues.
TEST_F(ResumeTest, ATerminatedSetGoesOn) {
  make_map("map", 512);
  for (const char* tile : {"1001", "1002"})
    std::filesystem::copy_file(path("map_normal.png"), path(std::string("rock_") + tile + ".png"));
  const std::vector<std::string> set = multum_command(
      {"bake", path("rock_<UDIM>.png"), "-o", path("rock_<UDIM>.ndf.exr"), "--no-measure", "--quiet", "--resume"});
  Program stopped(set);
  wait_for_rows(stopped, path(".multum-partial-rock_1002.ndf.exr"), 2);
  stopped.send(SIGTERM);
  EXPECT_EQ(stopped.wait().exit_code, 130) << "the bake ended before the signal";
  ASSERT_TRUE(std::filesystem::exists(path("rock_1001.ndf.exr")));
  EXPECT_FALSE(std::filesystem::exists(path("rock_1002.ndf.exr")));
  EXPECT_TRUE(has_rows(path(".multum-partial-rock_1002.ndf.exr"), 2));
  const auto first = std::filesystem::last_write_time(path("rock_1001.ndf.exr"));
  ASSERT_EQ(run_program(set).exit_code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(path("rock_1001.ndf.exr")), first);
  EXPECT_EQ(read_movmf_header(path("rock_1002.ndf.exr")).header.provenance.content_hash,
            read_movmf_header(path("rock_1001.ndf.exr")).header.provenance.content_hash);
}

// In a map of this size, fitting the finest level takes less time than storing its rows.
TEST_F(ResumeTest, WhoDoesNotAskForItKeepsAllButTheFinestLevel) {
  make_map("map", 1024);
  ASSERT_EQ(run_program(command({})).exit_code, 0);
  const std::string whole = content_hash();
  std::filesystem::remove(path("map.ndf.exr"));
  Program bake(command({}));
  wait_for_rows(bake, partial(), 3);
  bake.send(SIGKILL);
  ASSERT_EQ(bake.wait().signal, SIGKILL) << "the bake ended before the kill";
  EXPECT_FALSE(has_rows(partial(), 1));
  const ProgramResult resumed = run_program(command({"--resume", "--report", path("report.json")}));
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_GT(rows_resumed(), 100u);
  EXPECT_EQ(content_hash(), whole);
}

TEST_F(ResumeTest, WhatAnotherVersionLeftIsRefusedAndStays) {
  make_map("map", 32);
  WorkFolder::take(partial())->leave();
  write_bytes(partial() + "/progress", std::string(64, 'a') + "\n3 0 4 0123456789abcdef\n");
  write_bytes(partial() + "/level-3.lobes", std::string(1024, ' '));
  expect_refusal(run_program(command({"--resume"})), exit_code(ErrorCode::kEnvironment),
                 {".multum-partial-map.ndf.exr/progress", "another version of multum", "delete it"});
  EXPECT_TRUE(std::filesystem::exists(partial() + "/level-3.lobes"));
  std::filesystem::remove(partial() + "/progress");
  EXPECT_EQ(run_program(command({"--resume"})).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

TEST_F(ResumeTest, WhatAnotherBakeLeftIsNotTaken) {
  make_map("map", 512);
  kill_a_bake({"--lobes", "3"});
  ASSERT_EQ(run_program(command({"--resume", "--report", path("report.json")})).exit_code, 0);
  EXPECT_EQ(rows_resumed(), 0u);
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

// Both files are complete. Only the first bake uses the folder of partial results. The second bake does not need it.
TEST_F(ResumeTest, TwoBakesOfOneOutputAtOnceAreEachWhole) {
  make_map("map", 512);
  ASSERT_EQ(run_program(command({})).exit_code, 0);
  const std::string whole = content_hash();
  std::filesystem::remove(path("map.ndf.exr"));
  Program first(command({"--force"}));
  wait_for_rows(first, partial(), 4);
  Program second(command({"--force", "--resume"}));
  const ProgramResult of_first = first.wait(), of_second = second.wait();
  EXPECT_EQ(of_first.exit_code, 0) << of_first.err;
  EXPECT_EQ(of_second.exit_code, 0) << of_second.err;
  EXPECT_EQ(content_hash(), whole);
  EXPECT_FALSE(std::filesystem::exists(partial()));
}

class RegionTest : public CliTest {
 protected:
  // Makes the four-quarter map with 256 texels per side, and a copy that has a dome at (192, 160), in the quarter with
  // noise.
  void SetUp() override {
    make_map("map", kSide);
    NormalMapSettings reading;
    reading.green = GreenAxis::kUp;  // uses the convention of the file, so that unedited texels stay unchanged
    NormalMap map = read_normal_map(path("map_normal.png"), reading, 1, nullptr);
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto i = static_cast<std::size_t>(y * kSide + x);
        const double dx = (x - 191.5) / 20.0, dy = (y - 159.5) / 20.0, squared = dx * dx + dy * dy;
        if (squared >= 0.9) continue;
        map.x[i] = static_cast<float>(dx);
        map.y[i] = static_cast<float>(-dy);
        map.z[i] = static_cast<float>(std::sqrt(1.0 - squared));
      }
    write_png16(path("edited.png"), kSide, kSide, normal_codes(map), "Linear");
    ASSERT_EQ(bake("map_normal.png", "old.ndf.exr", {}).exit_code, 0);
  }
  ProgramResult bake(const std::string& map, const std::string& output, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"bake", path(map), "-o",       path(output),          "--green",
                                          "up",   "--quiet", "--report", path(output + ".json")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum(arguments);
  }
  // Returns the whole map's error for each BRDF. Each error is a mean over points and levels.
  std::map<std::string, double> errors(const std::string& output) const {
    std::ifstream in(path(output + ".json"));
    std::map<std::string, double> sums;
    const nlohmann::json report = nlohmann::json::parse(in);
    for (const auto& row : report.at("measured_error"))
      if (row.at("level").get<int>() > 0) sums[row.at("brdf")] += row.at("relative_l1").get<double>();
    return sums;
  }

  static constexpr int kSide = 256;
  const std::vector<std::string> region_ = {"--region", "172,140,40,40", "--onto", path("old.ndf.exr")};
};

TEST_F(RegionTest, OnlyTheRegionItsHaloAndItsAncestorsChange) {
  const ProgramResult result = bake("edited.png", "new.ndf.exr", region_);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const MovmfMipmap old = read_movmf_mipmap(path("old.ndf.exr")), now = read_movmf_mipmap(path("new.ndf.exr"));
  for (std::size_t l = 0; l < old.levels.size(); ++l) {
    const MovmfLevel &a = old.levels[l], &b = now.levels[l];
    const int size = kSide >> l, halo = l == 0 ? 4 : 2;  // level 0: the texels that level 1's halo covers
    bool changed = false;
    for (std::size_t i = 0; i < a.lobes[0].size(); ++i) {
      bool same = true;
      for (std::size_t j = 0; j < a.lobes.size(); ++j) same = same && a.lobes[j][i] == b.lobes[j][i];
      changed = changed || !same;
      const int x = static_cast<int>(i) % size, y = static_cast<int>(i) / size;
      const bool inside =
          x >= (172 >> l) - halo && x <= (211 >> l) + halo && y >= (140 >> l) - halo && y <= (179 >> l) + halo;
      EXPECT_TRUE(same || inside) << "level " << l << " texel (" << x << ", " << y << ")";
    }
    EXPECT_TRUE(changed) << "level " << l;
  }
}

// The error is at most 1 % higher than the error of a full bake.
TEST_F(RegionTest, IsNearlyAsGoodAsAWholeBake) {
  ASSERT_EQ(bake("edited.png", "new.ndf.exr", region_).exit_code, 0);
  ASSERT_EQ(bake("edited.png", "whole.ndf.exr", {}).exit_code, 0);
  const auto region = errors("new.ndf.exr"), whole = errors("whole.ndf.exr");
  ASSERT_EQ(whole.size(), 4u);
  for (const auto& [brdf, error] : whole) EXPECT_LT(region.at(brdf), 1.01 * error + 1e-4) << brdf;
}

TEST_F(RegionTest, OntoItselfAndTwiceIsRecognisedAsUnchanged) {
  ASSERT_EQ(bake("edited.png", "old.ndf.exr", region_).exit_code, 0);
  const BakedProvenance from = read_movmf_header(path("old.ndf.exr")).header.provenance;
  EXPECT_NE(from.settings.find("\"region\":[172,140,40,40]"), std::string::npos) << from.settings;
  EXPECT_EQ(from.source_name, "edited.png");
}

// Otherwise the file would claim to be baked from the edited map, but still hold the old map outside the region.
TEST_F(RegionTest, ARegionThatMissesAnEditIsRefused) {
  const ProgramResult right = bake("edited.png", "auto.ndf.exr", {"--region", "auto", "--onto", path("old.ndf.exr")});
  ASSERT_EQ(right.exit_code, 0) << right.err;
  const std::string settings = read_movmf_header(path("auto.ndf.exr")).header.provenance.settings;
  const std::size_t at = settings.find("\"region\":[") + 10;
  const std::string found = settings.substr(at, settings.find(']', at) - at);
  int x = 0, y = 0, width = 0, height = 0;
  ASSERT_EQ(std::sscanf(found.c_str(), "%d,%d,%d,%d", &x, &y, &width, &height), 4) << settings;
  EXPECT_GE(x, 172);
  EXPECT_GE(y, 140);
  EXPECT_LE(x + width, 212);
  EXPECT_LE(y + height, 180);
  EXPECT_GT(width * height, 20 * 20);
  for (const int side : {0, 1, 2, 3}) {  // the region is one texel too small, on each side in turn
    const std::string region = fmt::format("{},{},{},{}", x + (side == 0 ? 1 : 0), y + (side == 1 ? 1 : 0),
                                           width - (side % 2 == 0 ? 1 : 0), height - (side % 2 == 1 ? 1 : 0));
    const ProgramResult missed = bake("edited.png", "new.ndf.exr", {"--region", region, "--onto", path("old.ndf.exr")});
    EXPECT_EQ(missed.exit_code, exit_code(ErrorCode::kInput));
    expect_says(missed.err, {"edited.png", found, region, "--region auto"});
    EXPECT_FALSE(std::filesystem::exists(path("new.ndf.exr")));
  }
  ASSERT_EQ(bake("edited.png", "new.ndf.exr", {"--region", found, "--onto", path("old.ndf.exr")}).exit_code, 0);
  EXPECT_EQ(read_movmf_header(path("new.ndf.exr")).header.provenance.content_hash,
            read_movmf_header(path("auto.ndf.exr")).header.provenance.content_hash);
}

TEST_F(RegionTest, ColoursCountAsTheNormalsDo) {
  const auto colours = [&](const std::string& name, std::uint16_t corner) {
    std::vector<std::uint16_t> rgb(3 * kSide * kSide, 20000);
    rgb.back() = corner;
    write_png16(path(name), kSide, kSide, rgb, "Linear");
  };
  colours("old_albedo.png", 20000);
  colours("albedo.png", 20300);
  ASSERT_EQ(bake("edited.png", "old.ndf.exr", {"--albedo", path("old_albedo.png"), "--force"}).exit_code, 0);
  const ProgramResult missed =
      bake("edited.png", "new.ndf.exr",
           {"--albedo", path("albedo.png"), "--region", "0,0,255,256", "--onto", path("old.ndf.exr")});
  EXPECT_EQ(missed.exit_code, exit_code(ErrorCode::kInput));
  expect_says(missed.err, {"255,255,1,1"});
}

TEST_F(RegionTest, WeightsOfTheRegionChange) {
  const auto weights = [&](const std::string& name, std::uint16_t inside) {
    std::vector<std::uint16_t> rgb(3 * kSide * kSide, 20000);
    for (int y = 140; y < 180; ++y)
      for (int x = 172; x < 212; ++x) rgb[static_cast<std::size_t>(3 * (y * kSide + x))] = inside;
    write_png16(path(name), kSide, kSide, rgb, "Linear");
  };
  weights("old_weights.png", 20000);
  weights("weights.png", 60000);
  ASSERT_EQ(bake("edited.png", "old.ndf.exr", {"--weights", path("old_weights.png"), "--force"}).exit_code, 0);
  std::vector<std::string> region = region_;
  region.insert(region.end(), {"--weights", path("weights.png")});
  const ProgramResult result = bake("edited.png", "new.ndf.exr", region);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ASSERT_EQ(bake("edited.png", "whole.ndf.exr", {"--weights", path("weights.png")}).exit_code, 0);
  const MovmfMipmap old = read_movmf_mipmap(path("old.ndf.exr")), now = read_movmf_mipmap(path("new.ndf.exr")),
                    whole = read_movmf_mipmap(path("whole.ndf.exr"));
  constexpr std::size_t kLevel = 3, kWidth = kSide >> kLevel;
  // Returns sums over the lobes of two texels: the texel in the middle of the region, and the first texel.
  const auto first_weight = [&](const MovmfMipmap& mipmap, std::size_t texel) {
    float sum = 0.0f;
    for (const std::vector<float>& lobe : mipmap.levels[kLevel].weights) sum += lobe[texel * 3];
    return sum;
  };
  const std::size_t middle = (160 >> kLevel) * kWidth + (192 >> kLevel);
  EXPECT_GT(first_weight(now, middle), 2.0f * first_weight(old, middle));
  EXPECT_NEAR(first_weight(now, middle), first_weight(whole, middle), 0.01f);
  EXPECT_EQ(first_weight(now, 0), first_weight(old, 0));
}

TEST_F(RegionTest, WithoutLevelZeroNobodyKnowsWhatHasChanged) {
  ASSERT_EQ(bake("edited.png", "old.ndf.exr", {"--first-level", "1", "--force"}).exit_code, 0);
  const std::vector<std::string> first = {"--first-level", "1", "--onto", path("old.ndf.exr"), "--region"};
  const auto with = [&](const char* region) {
    std::vector<std::string> all = first;
    all.emplace_back(region);
    return bake("edited.png", "new.ndf.exr", all);
  };
  const ProgramResult found = with("auto");
  EXPECT_EQ(found.exit_code, exit_code(ErrorCode::kUsage));
  expect_says(found.err, {"old.ndf.exr", "level 0", "x,y,width,height"});
  const ProgramResult given = multum({"bake", path("edited.png"), "-o", path("new.ndf.exr"), "--green", "up",
                                      "--first-level", "1", "--onto", path("old.ndf.exr"), "--region", "0,0,8,8"});
  EXPECT_EQ(given.exit_code, 0) << given.err;
  expect_says(given.err, {"old.ndf.exr", "level 0", "0,0,8,8"});
}

TEST_F(RegionTest, WhatDoesNotFitIsRefused) {
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& parts) {
    const ProgramResult result = bake("edited.png", "new.ndf.exr", more);
    EXPECT_NE(result.exit_code, 0);
    expect_says(result.err, parts);
    EXPECT_FALSE(std::filesystem::exists(path("new.ndf.exr")));
  };
  refused({"--region", "0,0,300,10", "--onto", path("old.ndf.exr")}, {"0,0,300,10", "256 x 256"});
  refused({"--region", "0,0,8", "--onto", path("old.ndf.exr")}, {"0,0,8", "x,y,width,height"});
  refused({"--region", "0,0,8,8"}, {"--region", "--onto"});
  refused({"--onto", path("old.ndf.exr")}, {"--region", "--onto"});
  refused({"--region", "0,0,8,8", "--onto", path("none.ndf.exr")}, {"none.ndf.exr"});
  refused({"--lobes", "3", "--region", "0,0,8,8", "--onto", path("old.ndf.exr")}, {"old.ndf.exr", "lobes: 4", "3"});
  refused({"-d", "half", "--region", "0,0,8,8", "--onto", path("old.ndf.exr")}, {"old.ndf.exr", "snorm16", "half"});
}

}  // namespace
}  // namespace multum::testing
