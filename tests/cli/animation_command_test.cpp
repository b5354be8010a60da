// SPDX-License-Identifier: Apache-2.0
// Tests multum animation, which writes a job file from a folder of renders, or writes nothing.
#include "host/fields/inference/job/animation_job_reading.h"
#include "tests/cli/program.h"
#include "tests/unit/fields/inference/animation_test_scene.h"

namespace multum::testing {
namespace {

class AnimationCommandTest : public CliTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(path("renders"));
    write_demo_folder(path("renders"), false);
  }
  void expect_refused(const std::vector<std::string>& arguments, int code, const std::vector<std::string>& parts) {
    const auto before = folder_.names();
    std::vector<std::string> command = {"animation"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    const ProgramResult result = multum(command);
    expect_refusal(result, code, parts);
    EXPECT_EQ(result.out.find("written"), std::string::npos) << result.out;
    EXPECT_EQ(folder_.names(), before);
  }
};

TEST_F(AnimationCommandTest, WritesAJobThatIsRead) {
  for (int i = 0; i < 2; ++i) {  // the second run overwrites the first file
    const ProgramResult result = multum({"animation", path("renders"), "-o", path("animation.toml")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    expect_says(result.out, {"animation.toml: written", "4 samples", "view 2", "light 2", "2 cameras", "1 objects",
                             "2 layers", "4 x 3 pixels"});
    EXPECT_EQ(folder_.names(), (std::set<std::string>{"animation.toml", "renders"}));
    const AnimationJob job = read_animation_job(path("animation.toml"));
    EXPECT_EQ(job.samples.size(), 4u);
    EXPECT_EQ(job.samples[3].radiance, path("renders/rad_v01_p01.exr"));
    write_bytes(path("animation.toml"), "an older file");
  }
}

TEST_F(AnimationCommandTest, FromWithinTheFolder) {
  std::filesystem::current_path(path("renders"));
  const ProgramResult result = multum_program({"animation", ".", "-o", "animation.toml"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(read_bytes("animation.toml").find("geometry = \"geometry.gltf\""), std::string::npos);
  // Runs the command in its own process. Otherwise a decoding child of an earlier command would be used, in the working
  // folder in which it was started.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(std::_Exit(read_animation_job("animation.toml").samples.size() == 4 ? 0 : 1),
              ::testing::ExitedWithCode(0), "");
  std::filesystem::current_path("/");
}

TEST_F(AnimationCommandTest, Refusals) {
  const std::string output = path("animation.toml");
  expect_refused({path("none"), "-o", output}, kInput, {"none", "not a folder", "scene.json"});
  expect_refused({path("."), "-o", output}, kInput, {folder_.path(), "no scene.json"});
  expect_refused({path("renders")}, kUsage, {"--output"});
  expect_refused({"-o", output}, kUsage, {"folder"});
  expect_refused({path("renders"), "-o", "/proc/none/animation.toml"}, kEnvironment, {"/proc/none"});
  expect_refused({path("renders"), "-o", path("renders")}, kUsage, {"renders"});
  const std::string scene = read_bytes(path("renders/scene.json"));
  expect_refused({path("renders"), "-o", path("renders/scene.json")}, kUsage, {"scene.json"});
  EXPECT_EQ(read_bytes(path("renders/scene.json")), scene);
  std::filesystem::remove(path("renders/rad_v01_p00.exr"));
  expect_refused({path("renders"), "-o", output}, kInput, {"rad_v01_p00.exr", "scene.json"});
}

}  // namespace
}  // namespace multum::testing
