// SPDX-License-Identifier: Apache-2.0
// Tests multum-view play on a small animation that the test infers and packs: the same frames as `sample` with any
// number of threads, cameras between samples, damage, too little memory, and refusals.
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/fields/codec/field_unpacking.h"
#include "host/formats/image/small_picture.h"
#include "host/foundation/base/error.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class PlayCommandTest : public TracedSceneTest {
 protected:
  void SetUp() override {
    TracedScene scene;
    scene.views = 3;
    infer_scene(scene);
    ASSERT_EQ(multum({"pack", path("out"), "-o", path("field.mpt"), "--lambda", "20"}).exit_code, 0);
  }
  static ProgramResult view(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum-view");
    arguments.insert(arguments.end(), {"--context", "osmesa"});
    return run_program(arguments);
  }
  ProgramResult play(const std::string& frames, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"play", path("field.mpt"), "-o", path(frames)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return view(arguments);
  }
  std::string frame_path(const std::string& frames, int frame) const {
    return path(fmt::format("{}/frame_{:04}.png", frames, frame));
  }
  Png8Image frame(const std::string& frames, int number) const {
    return read_small_picture(frame_path(frames, number), 1000);
  }
  Png8Image sample(const std::string& at) const {
    view({"sample", path("field.mpt"), "--at", at, "-o", path("sample.png")});  // also draws a damaged field
    return read_small_picture(path("sample.png"), 1000);
  }
  json statistics(const std::string& frames) const {
    return json::parse(read_bytes(path(frames + "/statistics.json")));
  }
};

/// Returns the largest difference of two pictures, in 8-bit values.
int difference(const Png8Image& a, const Png8Image& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.interleaved.size(), b.interleaved.size());
  int most = 0;
  for (std::size_t i = 0; i < std::min(a.interleaved.size(), b.interleaved.size()); ++i)
    most = std::max(most, std::abs(int{a.interleaved[i]} - int{b.interleaved[i]}));
  return most;
}

TEST_F(PlayCommandTest, FramesAtSamplesAreThoseOfSample) {
  const ProgramResult played = play("frames", {"--path", "view=0..2,light=1", "--frames", "3"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  expect_says(played.out, {"written: 3 frames", "; decoded "});
  ASSERT_EQ(play("mixed", {"--path", "view=0..2,light=1", "--frames", "3", "--linear"}).exit_code, 0);
  ASSERT_EQ(play("coarse", {"--path", "view=0..2,light=1", "--frames", "3", "--supersampling", "1"}).exit_code, 0);
  for (int v = 0; v < 3; ++v) {
    const Png8Image exact = sample(fmt::format("{},1", v));
    EXPECT_EQ(difference(frame("frames", v), exact), 0) << v;
    // Sums of half-float images differ from textures by at most 2e-3, which is less than an 8-bit step.
    EXPECT_LE(difference(frame("mixed", v), exact), 1) << v;
    EXPECT_GT(difference(frame("coarse", v), exact), 2) << "edges are not averaged";
  }
  EXPECT_GT(difference(frame("frames", 0), frame("frames", 2)), 20);
  const json found = statistics("frames");
  EXPECT_EQ(found["damaged"], json::array());
  ASSERT_EQ(found["frames"].size(), 3u);
  for (const json& one : found["frames"]) {
    EXPECT_EQ(one["images_missing"], 0);
    EXPECT_EQ(one["layers_old"], 0);
    EXPECT_GT(one["images_needed"], 0);
  }
  EXPECT_EQ(found["frames"][1]["point"], (json{1.0, 1.0}));
  EXPECT_LE(found["bytes_most"], found["memory_max"]);
}

TEST_F(PlayCommandTest, ThreadsAndMemoryChangeNoFrame) {
  const std::vector<std::string> path_of_all = {"--path", "view=0..2,light=0.5-0.5*cos(6*t)", "--frames", "8",
                                                "--linear"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), path_of_all.begin(), path_of_all.end());
    return more;
  };
  ASSERT_EQ(play("one", with({"--threads", "1", "--ahead", "0"})).exit_code, 0);
  ASSERT_EQ(play("four", with({"--threads", "4"})).exit_code, 0);
  const ProgramResult little =
      play("little", with({"--memory", "6M", "--lifetime", "0", "--debug-picture", path("d.png")}));
  ASSERT_EQ(little.exit_code, 0) << little.err;
  for (int f = 0; f < 8; ++f) {
    EXPECT_EQ(read_bytes(frame_path("one", f)), read_bytes(frame_path("four", f))) << f;
    EXPECT_EQ(read_bytes(frame_path("one", f)), read_bytes(frame_path("little", f))) << f;
  }
  EXPECT_LE(statistics("little")["bytes_most"], 6 << 20);
  EXPECT_EQ(read_small_picture(path("d.png"), 1000).width, 8 * 4);
}

TEST_F(PlayCommandTest, WithAColdCacheEachFrameDecodesAll) {
  const std::vector<std::string> still = {"--path", "view=1,light=1", "--frames", "3", "--ahead", "0"};
  ASSERT_EQ(play("warm", still).exit_code, 0);
  std::vector<std::string> cold = still;
  cold.emplace_back("--cold");
  ASSERT_EQ(play("cold", cold).exit_code, 0);
  const json warm_frames = statistics("warm")["frames"], cold_frames = statistics("cold")["frames"];
  for (int f = 0; f < 3; ++f) {
    EXPECT_EQ(cold_frames[f]["chunks_decoded"], warm_frames[0]["chunks_decoded"]);
    EXPECT_EQ(cold_frames[f]["images_decoded"], warm_frames[0]["images_decoded"]);
    EXPECT_GT(cold_frames[f]["decoding_processor_ms"], 0.0);
    EXPECT_EQ(read_bytes(frame_path("cold", f)), read_bytes(frame_path("warm", f)));
  }
  EXPECT_EQ(warm_frames[1]["chunks_decoded"], 0);
}

TEST_F(PlayCommandTest, CamerasMoveBetweenSamplesAndTexturesAreMixedWhenAsked) {
  ASSERT_EQ(play("half", {"--path", "view=0.4,light=0.4", "--frames", "1"}).exit_code, 0);
  ASSERT_EQ(play("mixed", {"--path", "view=0.4,light=0.4", "--frames", "1", "--linear"}).exit_code, 0);
  ASSERT_EQ(play("beyond", {"--path", "view=-5,light=99", "--frames", "1"}).exit_code, 0);
  const Png8Image half = frame("half", 0);
  EXPECT_GT(difference(half, sample("0,0")), 10) << "another camera";
  EXPECT_GT(difference(half, frame("mixed", 0)), 3) << "another light's share";
  EXPECT_LE(difference(frame("beyond", 0), sample("0,1")), 1) << "values beyond the samples are clamped";
}

TEST_F(PlayCommandTest, APathThatWasRecordedIsPlayed) {
  // At 2 frames per second, frames show the positions after 0, 0.5, 1, 1.5 and 2 s of 2.5 s. At 0.5 s the path has two
  // positions, and the second one is shown.
  const ProgramResult played = play("recorded", {"--path", MULTUM_RECORDED_PATH, "--rate", "2"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const json frames = statistics("recorded")["frames"];
  const std::vector<std::vector<double>> points = {{0, 1}, {2, 0}, {1.5, 0.125}, {1, 0.25}, {0.5, 0.375}};
  ASSERT_EQ(frames.size(), points.size());
  for (std::size_t f = 0; f < points.size(); ++f) EXPECT_EQ(frames[f]["point"], json(points[f])) << f;
  EXPECT_LE(difference(frame("recorded", 1), sample("2,0")), 1);
  ASSERT_EQ(play("again", {"--path", MULTUM_RECORDED_PATH, "--rate", "2", "--frames", "6"}).exit_code, 0);
  EXPECT_EQ(statistics("again")["frames"][5]["point"], json(points[0])) << "the path must start again after its end";
  const auto refused = [&](const std::string& text, const std::string& rate, const std::vector<std::string>& parts) {
    write_bytes(path("p.json"), text);
    const ProgramResult result = play("none", {"--path", path("p.json"), "--rate", rate});
    EXPECT_NE(result.exit_code, 0);
    expect_says(result.err, parts);
  };
  refused("view=1", "30", {"p.json", "not JSON"});
  refused(R"({"multumPath":1,"parameters":["sun"],"positions":[[0,0],[1,0]]})", "30", {"p.json", "sun", "light"});
  refused(read_bytes(MULTUM_RECORDED_PATH), "4000", {"10000 frames", "--frames", "--rate"});
}

TEST_F(PlayCommandTest, WithoutWaitingWhatIsThereIsDrawn) {
  const ProgramResult played = play(
      "frames", {"--path", "view=0..2,light=0..1", "--frames", "30", "--no-wait", "--upload", "64K", "--threads", "1"});
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const json found = statistics("frames");
  for (const json& one : found["frames"]) EXPECT_LE(one["images_missing"], one["images_needed"]);
  // By the end of the path, most images are decoded. On every machine, at least the images of the last sample are
  // decoded.
  EXPECT_LE(found["bytes_most"], found["memory_max"]);
  double sum = 0.0, count = 0.0;
  const Png8Image shown = frame("frames", 29), exact = sample("2,1");
  for (std::size_t i = 0; i < shown.interleaved.size(); ++i, ++count)
    sum += std::abs(int{shown.interleaved[i]} - int{exact.interleaved[i]});
  EXPECT_LT(sum / count, 20.0) << "the picture must have no hole and no other object";
}

TEST_F(PlayCommandTest, ADamagedChunkIsLeftOutAndNamed) {
  const PackedFieldFile packed(path("field.mpt"));
  std::size_t number = 0;
  while (packed.section_name(number).find("layer 'diffuse' of object 'ground'") == std::string::npos) ++number;
  std::string bytes = read_bytes(path("field.mpt"));
  bytes.at(packed.index().sections()[number].offset + 30) ^= 0x40;
  write_bytes(path("field.mpt"), bytes);
  const ProgramResult played = play("frames", {"--path", "view=1", "--frames", "1"});
  EXPECT_EQ(played.exit_code, exit_code(ErrorCode::kVerification));
  expect_says(played.err, {"left out", "layer 'diffuse' of object 'ground'"});
  EXPECT_LE(difference(frame("frames", 0), sample("1,0")), 1);
  EXPECT_EQ(statistics("frames")["damaged"].size(), 1u);
}

TEST_F(PlayCommandTest, RefusesWhatCannotBePlayed) {
  const auto refused = [&](std::vector<std::string> more, int code, const std::vector<std::string>& parts) {
    const ProgramResult result = play("frames", std::move(more));
    EXPECT_EQ(result.exit_code, code) << result.err;
    expect_says(result.err, parts);
    EXPECT_FALSE(fs::exists(frame_path("frames", 0)));
  };
  refused({"--path", "vew=1"}, 2, {"'vew'", "did you mean 'view'"});
  refused({"--path", "view=1+"}, 2, {"path", "expected"});
  refused({"--path", "view=1/t", "--frames", "2"}, 2, {"'view'", "finite"});
  refused({"--path", "view=1", "--memory", "12Q"}, 2, {"--memory '12Q'", "800M"});
  refused({"--path", "view=1", "--memory", "1K"}, 2, {"1024 bytes"});
  refused({"--path", "view=1", "--frames", "0"}, 2, {"--frames"});
  refused({"--path", "view=1", "--upload", "1"}, 2, {"uploads of 1 bytes"});
  refused({"--path", "view=1", "--debug-picture", path("x.jpg")}, 2, {"x.jpg"});
  refused({"--path", "view=1", "--debug-picture", path("field.mpt")}, 2, {"field.mpt"});
  const ProgramResult folder = view({"play", path("out"), "--path", "view=1", "-o", path("frames")});
  EXPECT_EQ(folder.exit_code, 3);
  expect_says(folder.err, {"not a packed field", "multum pack"});
  write_bytes(path("field.mpt"), read_bytes(path("field.mpt")).substr(0, 200));
  refused({"--path", "view=1"}, 3, {"field.mpt", "bytes"});
}

}  // namespace
}  // namespace multum::testing
