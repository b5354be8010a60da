// SPDX-License-Identifier: Apache-2.0
// Tests jobs of texture inference. A job that is written and read again is the same, and jobs can be made from folders.
// Each error message names the line, the key, the value found and the value expected.
#include "host/fields/inference/job/animation_job_reading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

void replace_once(std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from << " in\n" << text;
  text.replace(at, from.size(), to);
}

class AnimationJobTest : public ::testing::Test {
 protected:
  void make(bool moves) {
    write_demo_folder(folder_.path(), moves);
    text_ = animation_job_text(job_for_folder(folder_.path()), folder_.path());
  }
  std::string job_path() const { return folder_ / "animation.toml"; }
  AnimationJob read(const std::string& text) const {
    write_bytes(job_path(), text);
    return read_animation_job(job_path());
  }
  // Replaces the first `from` by `to`. The error message must name the line in which `from` begins and contain all of
  // `parts`.
  void expect_refused(const std::string& from, const std::string& to, std::vector<std::string> parts) const {
    const std::size_t at = text_.find(from);
    ASSERT_NE(at, std::string::npos) << from << " in\n" << text_;
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    std::string text = text_;
    text.replace(at, from.size(), to);
    parts.insert(parts.begin(), job_path() + ":" + std::to_string(line) + ": ");
    SCOPED_TRACE(to);
    expect_error(ErrorCode::kInput, parts, [&] { read(text); });
  }
  void expect_folder_refused(const std::vector<std::string>& parts) const {
    expect_error(ErrorCode::kInput, parts, [&] { job_for_folder(folder_.path()); });
  }
  void edit_scene(const std::function<void(nlohmann::json&)>& edit) const {
    nlohmann::json scene = nlohmann::json::parse(read_bytes(folder_ / "scene.json"));
    edit(scene);
    write_bytes(folder_ / "scene.json", scene.dump());
  }

  TemporaryFolder folder_;
  std::string text_;
};

TEST_F(AnimationJobTest, AFolderWhoseLightMoves) {
  make(false);
  const AnimationJob job = job_for_folder(folder_.path());
  EXPECT_EQ(job.path, job_path());
  EXPECT_EQ(job.geometry_file, folder_ / "geometry.gltf");
  EXPECT_EQ(job.width, 4);
  EXPECT_EQ(job.height, 3);
  EXPECT_EQ(job.parameters, (std::vector<AnimationParameter>{{"view", 2, true}, {"light", 2, false}}));
  EXPECT_EQ(job.layers,
            (std::vector<AnimationLayer>{{"diffuse", {"diffuse"}, {"light"}},
                                         {"view_dependent", {"glossy", "transmission"}, {"view", "light"}}}));
  ASSERT_EQ(job.objects.size(), 1u);
  EXPECT_EQ(job.objects[0].mesh, "thing");
  EXPECT_EQ(job.objects[0].cryptomatte, "thing");
  EXPECT_EQ(job.objects[0].index, 0);
  ASSERT_EQ(job.cameras.size(), 2u);
  EXPECT_EQ(job.cameras[1].world_to_camera[3], glm::dvec4(-0.125, -0.25, -2.0, 1.0));  // the last column
  EXPECT_EQ(job.cameras[0].projection[2][3], -1.0);
  ASSERT_EQ(job.samples.size(), 4u);
  EXPECT_EQ(job.samples[1].name, "v00_p01");
  EXPECT_EQ(job.samples[1].radiance, folder_ / "rad_v00_p01.exr");
  EXPECT_EQ(job.samples[1].geometry, folder_ / "geom_v00.exr");
  EXPECT_EQ(job.samples[2].camera, 1);
}

TEST_F(AnimationJobTest, AFolderWhoseObjectMoves) {
  make(true);
  const AnimationJob job = job_for_folder(folder_.path());
  EXPECT_EQ(job.parameters[1].name, "motion");
  EXPECT_EQ(job.layers[0].depends_on, std::vector<std::string>{"motion"});
  EXPECT_EQ(job.objects[0].index, 1);
  EXPECT_EQ(job.objects[0].cryptomatte, "");
  EXPECT_EQ(job.samples[0].geometry, folder_ / "geom_v00.exr");
  EXPECT_EQ(job.samples[1].geometry, "") << "the view takes the geometry of its first sample";
  EXPECT_EQ(job.samples[1].object_index, folder_ / "id_v00_p01.png");
  EXPECT_EQ(job.samples[1].object_to_world.at("thing")[3], glm::dvec4(0.0, 0.0, 0.125, 1.0));
  // An OBJ file is in the world space of its export, whereas the matrix of a sample is relative to the object's own
  // space.
  edit_scene([](auto& scene) { scene["objects"]["thing"]["object_to_world"][2][3] = 0.5; });
  EXPECT_EQ(job_for_folder(folder_.path()).samples[1].object_to_world.at("thing")[3].z, 0.125);
  fs::remove(folder_ / "geometry.gltf");
  write_bytes(folder_ / "geometry.obj",
              "o thing_Mesh\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  const AnimationJob of_obj = job_for_folder(folder_.path());
  EXPECT_EQ(of_obj.objects[0].mesh, "thing_Mesh");
  EXPECT_EQ(of_obj.samples[1].object_to_world.at("thing_Mesh")[3].z, 0.125 - 0.5);
}

TEST_F(AnimationJobTest, IsReadBackEqual) {
  for (const bool moves : {false, true}) {
    make(moves);
    AnimationJob job = job_for_folder(folder_.path());
    EXPECT_EQ(read(text_), job) << text_;
    // All values differ from their defaults. Some numbers need all of their digits, and some letters must be escaped.
    fs::create_directories(folder_ / "a \"b\"");
    fs::rename(job.samples[3].radiance, folder_ / "a \"b\"/c.exr");
    job.samples[3].radiance = folder_ / "a \"b\"/c.exr";
    job.uv_set = 1;
    job.depth = "";
    job.depth_tolerance = 0.1 + 0.2;
    job.radiance_max = 1e21;
    job.coverage_min = 0.0;
    job.supersampling = 8;
    job.parameters[0].block = 2;
    job.objects[0].name = "a \"b\" c";
    job.objects[0].layers = {"diffuse"};
    job.objects[0].texture = {"periodic", 1.0 / 3.0, 8.0, true, 1, 16.0, 0.0, 1e-300};
    job.cameras[1].world_to_camera[3][0] = -1.0 / 3.0;
    EXPECT_EQ(read(animation_job_text(job, folder_.path())), job) << animation_job_text(job, folder_.path());
    fs::rename(job.samples[3].radiance, folder_ / "rad_v01_p01.exr");
  }
}

TEST_F(AnimationJobTest, PathsAreAgainstTheJobsFolder) {
  make(false);
  fs::create_directory(folder_ / "jobs");
  write_bytes(folder_ / "jobs/a.toml", animation_job_text(job_for_folder(folder_.path()), folder_ / "jobs"));
  EXPECT_NE(read_bytes(folder_ / "jobs/a.toml").find("\"../rad_v00_p00.exr\""), std::string::npos);
  EXPECT_EQ(read_animation_job(folder_ / "jobs/a.toml").samples[0].radiance, folder_ / "rad_v00_p00.exr");
}

TEST_F(AnimationJobTest, TextureKeysOfObjectsGoBeforeThoseOfTheJob) {
  make(false);
  std::string text = text_;
  replace_once(text, "stretch_max = 1.25", "stretch_max = 3");
  replace_once(text, "layers = []\n", "layers = []\n[object.texture]\nwrap = \"periodic\"\n");
  const AnimationTexture texture = read(text).objects[0].texture;
  EXPECT_EQ(texture.stretch_max, 3.0);
  EXPECT_EQ(texture.wrap, "periodic");
}

TEST_F(AnimationJobTest, SamplesAreInTheOrderOfTheGrid) {
  make(false);
  std::string text = text_;
  replace_once(text, "at = [0, 1]", "at = [9, 9]");
  replace_once(text, "at = [1, 0]", "at = [0, 1]");
  replace_once(text, "at = [9, 9]", "at = [1, 0]");
  replace_once(text, "name = \"v01_p00\"\nradiance", "radiance");
  const AnimationJob job = read(text);
  EXPECT_EQ(job.samples[1].radiance, folder_ / "rad_v01_p00.exr");
  EXPECT_EQ(job.samples[1].name, "0_1") << "a sample without a name gets one";
  EXPECT_EQ(job.samples[2].name, "v00_p01");
}

TEST_F(AnimationJobTest, KeysAndTypes) {
  make(false);
  expect_error(ErrorCode::kInput, {folder_ / "none.toml", "cannot be read"},
               [&] { read_animation_job(folder_ / "none.toml"); });
  expect_refused("width = 4", "width = 4 4", {"TOML"});
  expect_refused("depth_tolerance = ", "depth_tolerence = ", {"depth_tolerence", "unknown key", "depth_tolerance"});
  expect_refused("stretch_max = ", "strech_max = ", {"texture.strech_max", "texture.stretch_max"});
  expect_refused("view = true", "qqqqqqqqq = true", {"parameter.qqqqqqqqq", "unknown key"});

  expect_refused("width = 4", "width = \"4\"", {"width", "\"4\"", "1 to 16384"});
  expect_refused("view = true", "view = 1", {"parameter.view", "1", "true or false"});
  expect_refused("cryptomatte = \"CryptoObject\"", "cryptomatte = 1979-05-27",
                 {"cryptomatte", "a date or time", "string"});
  expect_refused("passes = [\"diffuse\"]", "passes = \"diffuse\"", {"layer.passes", "\"diffuse\"", "list of strings"});
  expect_refused("passes = [\"diffuse\"]", "passes = [1]", {"layer.passes[0]", "1", "string"});
  expect_refused("at = [0, 0]", "at = 0", {"sample.at", "0", "list of integers"});
  expect_refused("at = [0, 0]", "at = [0, -1]", {"sample.at[1]", "-1", "at least 0"});

  std::string no_width = text_;
  replace_once(no_width, "width = 4", "");
  expect_error(ErrorCode::kInput, {folder_.path(), "the job", "no width"}, [&] { read(no_width); });
  expect_error(ErrorCode::kInput, {folder_.path(), "the job", "no parameter"},
               [&] { read("geometry = \"geometry.gltf\"\nwidth = 4\nheight = 3\n"); });
  expect_error(ErrorCode::kInput, {"parameter", "1", "tables, as [[parameter]]"},
               [&] { read("geometry = \"geometry.gltf\"\nwidth = 4\nheight = 3\nparameter = 1\n"); });
  expect_error(ErrorCode::kInput, {"parameter", "an array of 0", "tables"},
               [&] { read("geometry = \"geometry.gltf\"\nwidth = 4\nheight = 3\nparameter = []\n"); });
  expect_error(ErrorCode::kInput, {"parameter", "3", "tables"},
               [&] { read("geometry = \"geometry.gltf\"\nwidth = 4\nheight = 3\nparameter = [3]\n"); });
  replace_once(text_, "layers = []\n", "layers = []\ntexture = 7\n");
  expect_refused("texture = 7", "texture = 8", {"object.texture", "8", "table"});
}

TEST_F(AnimationJobTest, NumbersOutOfRange) {
  make(false);
  expect_refused("uv_set = 0", "uv_set = 8", {"uv_set", "8", "0 to 7"});
  expect_refused("width = 4", "width = 0", {"width", "0", "1 to 16384"});
  expect_refused("height = 3", "height = 16385", {"height", "16385"});
  expect_refused("depth_tolerance = 0.01", "depth_tolerance = 0", {"depth_tolerance", "0", "above 0"});
  expect_refused("supersampling = 4", "supersampling = 9", {"supersampling", "9", "from 1 to 8"});
  expect_refused("radiance_max = 1", "radiance_max = inf", {"radiance_max", "inf", "above 0"});
  expect_refused("coverage_min = 0.015625", "coverage_min = 1", {"coverage_min", "1", "from 0 to below 1"});
  expect_refused("stretch_max = 1.25", "stretch_max = -1", {"texture.stretch_max", "-1", "above 0"});
  expect_refused("stretch_max = 1.25", "stretch_max = nan", {"texture.stretch_max", "nan"});
  expect_refused("resolution_scale = 1", "resolution_scale = 8.5", {"texture.resolution_scale", "8.5", "up to 8"});
  expect_refused("side_max = 2048", "side_max = 20000", {"texture.side_max", "20000", "1 to 16384"});
  expect_refused("anisotropy = 1", "anisotropy = 0.5", {"texture.anisotropy", "0.5", "1 to 16"});
  expect_refused("pyramid_weight = 0.1", "pyramid_weight = -0.1", {"texture.pyramid_weight", "-0.1", "at least 0"});
  expect_refused("range_weight = 0", "range_weight = \"a\"", {"texture.range_weight", "\"a\""});
  expect_refused("wrap = \"clamp\"", "wrap = \"mirror\"", {"\"mirror\"", "\"clamp\"", "\"periodic\""});
  expect_refused("count = 2", "count = 0", {"parameter.count", "0"});
  expect_refused("block = 0", "block = -1", {"parameter.block", "-1", "0 to 65536"});
  std::string many = text_;
  replace_once(many, "count = 2", "count = 300");
  text_ = many;
  expect_refused("count = 2", "count = 300", {"parameter.count", "300", "at most 65536 samples in total"});
}

TEST_F(AnimationJobTest, NamesThatNothingAnswersTo) {
  make(false);
  expect_refused("depends_on = [\"light\"]", "depends_on = [\"lamp\"]",
                 {"layer.depends_on", "\"lamp\"", "unknown parameter", "view, light"});
  expect_refused("depends_on = [\"light\"]", "depends_on = [\"light\", \"light\"]", {"layer.depends_on", "twice"});
  expect_refused("passes = [\"diffuse\"]", "passes = []", {"layer.passes", "empty"});
  expect_refused("passes = [\"glossy\", ", "passes = [\"diffuse\", ", {"\"diffuse\"", "twice"});
  expect_refused("passes = [\"diffuse\"]", "passes = [\"difuse\"]",
                 {"\"difuse.R\"", "unknown channel", "rad_v00_p00.exr", "diffuse.R"});
  expect_refused("mesh = \"thing\"", "mesh = \"cup\"", {"object.mesh", "\"cup\"", "unknown object", "thing"});
  expect_refused("layers = []", "layers = [\"shiny\"]",
                 {"object.layers", "\"shiny\"", "unknown layer", "diffuse, view_dependent"});
  expect_refused("cryptomatte = \"thing\"", "cryptomatte = \"cup\"",
                 {"\"cup\"", "unknown name", "geom_v00.exr", "thing"});
  expect_refused("depth = \"Z\"", "depth = \"depth\"", {"depth", "\"depth\"", "unknown channel", "geom_v00.exr"});
  expect_refused("camera = \"v00\"", "camera = \"v07\"", {"sample.camera", "\"v07\"", "unknown camera", "v00, v01"});
  expect_refused("geometry = \"geometry.gltf\"", "geometry = \"none.gltf\"",
                 {"geometry", "\"none.gltf\"", "does not exist", "none.gltf"});
  expect_refused("radiance = \"rad_v00_p00.exr\"", "radiance = \"none.exr\"", {"sample.radiance", "\"none.exr\""});
  expect_refused("geometry = \"geom_v00.exr\"", "geometry = \".\"", {"sample.geometry", "\".\"", "does not exist"});
  expect_refused("name = \"view\"", "name = \"\"", {"parameter.name", "\"\"", "string"});
  for (const char* name : {"a/b", "a\\\\b", ".a", "a\\u0007b"})
    expect_refused("name = \"thing\"", std::string("name = \"") + name + '"', {"object.name is", "without /"});
}

TEST_F(AnimationJobTest, NamesThatAreThereTwice) {
  make(false);
  expect_refused("name = \"light\"", "name = \"view\"", {"parameter.name", "\"view\"", "already in use"});
  expect_refused("name = \"view_dependent\"", "name = \"diffuse\"", {"layer.name", "\"diffuse\"", "already in use"});
  expect_refused("name = \"v01\"", "name = \"v00\"", {"camera.name", "\"v00\""});
  expect_refused("name = \"v00_p01\"", "name = \"v00_p00\"",
                 {"sample.name", "\"v00_p00\"", "another sample already has"});
  std::string again = text_;
  replace_once(again, "# Matrices are",
               "[[object]]\nname = \"other\"\nmesh = \"thing\"\nindex = 1\ncryptomatte = \"thing\"\n# Matrices are");
  text_ = again;
  expect_refused("name = \"other\"", "name = \"thing\"", {"object.name", "\"thing\"", "already in use"});
  replace_once(text_, "index = 0", "index = 1");
  std::size_t second = text_.find("index = 1", text_.find("\"other\""));
  const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(second), '\n');
  expect_error(ErrorCode::kInput, {":" + std::to_string(line) + ": ", "object.index", "1", "another object"},
               [&] { read(text_); });
}

TEST_F(AnimationJobTest, TheGridMustBeWhole) {
  make(false);
  expect_refused("at = [0, 1]", "at = [0, 0]", {"sample.at", "[0, 0]", "another sample already has"});
  expect_refused("at = [0, 1]", "at = [0, 2]", {"sample.at", "[0, 2]", "0 to 1 along light"});
  expect_refused("at = [0, 1]", "at = [0]", {"sample.at", "1 numbers", "2, one per parameter (view, light)"});
  std::string fewer = text_;
  const std::size_t second = fewer.find("[[sample]]", fewer.find("[[sample]]") + 1);
  fewer.erase(second, fewer.find("[[sample]]", second + 1) - second);
  expect_error(ErrorCode::kInput, {"the job", "1 of 4 samples", "view 0, light 1"}, [&] { read(fewer); });
}

TEST_F(AnimationJobTest, Matrices) {
  make(false);
  const std::string camera = "world_to_camera = [[1, 0, 0, -0.25], [0, 1, 0, -0.25], [0, 0, 1, -2], [0, 0, 0, 1]]";
  expect_refused(camera, "world_to_camera = [1, 2]",
                 {"camera.world_to_camera", "an array of 2", "4 rows of 4 finite numbers"});
  expect_refused(camera, "world_to_camera = [[1, 0, 0, 0], [0, 1, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
                 {"camera.world_to_camera[1]", "an array of 3"});
  expect_refused(camera, "world_to_camera = [[1, 0, 0, 0], [0, 1, 0, nan], [0, 0, 1, 0], [0, 0, 0, 1]]",
                 {"camera.world_to_camera[1][3]", "nan"});
  expect_refused(camera, "world_to_camera = [[1, 0, 0, 0], [0, 1, 0, \"a\"], [0, 0, 1, 0], [0, 0, 0, 1]]",
                 {"camera.world_to_camera[1][3]", "\"a\""});
  expect_refused(camera, "world_to_camera = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [2, 3, 4, 1]]",
                 {"last row", "0 0 0 1", "column vectors"});
  expect_refused(camera, "world_to_camera = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
                 {"camera.world_to_camera", "mirrored or flat"});
  const std::string projection =
      "projection = [[16, 0, 0, 0], [0, 16, 0, 0], [0, 0, -1.02020202, -0.202020202], [0, 0, -1, 0]]";
  for (const char* other : {"[[16, 0, 0, 0], [0, 16, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]",    // orthographic
                            "[[16, 0, 0, 0], [0, 16, 0, 0], [0, 0, 1, -0.2], [0, 0, 1, 0]]",  // looks along +z
                            "[[-16, 0, 0, 0], [0, 16, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]]",
                            "[[16, 0, 0, 0], [0, -16, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]]",
                            "[[16, 0, 0, 1], [0, 16, 0, 0], [0, 0, -1, -0.2], [0, 0, -1, 0]]"})
    expect_refused(projection, std::string("projection = ") + other, {"camera.projection", "not a perspective"});
}

TEST_F(AnimationJobTest, ObjectsMustBeTold) {
  make(false);
  const std::string object = "[[object]]\nname = \"thing\"\nmesh = \"thing\"\ncryptomatte = ";
  expect_refused(object + "\"thing\"", object + "\"\"", {"object", "neither", "cryptomatte", "index"});
  expect_refused(
      "[[sample]]\nat = [0, 0]\nname = \"v00_p00\"\nradiance = \"rad_v00_p00.exr\"\ngeometry = \"geom_v00.exr\"",
      "[[sample]]\nat = [0, 0]\nname = \"v00_p00\"\nradiance = \"rad_v00_p00.exr\"",
      {"sample", "neither", "geometry", "object_index"});
  expect_refused("camera = \"v00\"\n", "object_index = \"rad_v00_p00.exr\"\ncamera = \"v00\"\n",
                 {"sample.object_index", "\"thing\"", "no index"});
  make(true);
  expect_refused("thing\" = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.125]",
                 "cup\" = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.125]",
                 {"sample.object_to_world.cup", "\"cup\"", "unknown object"});
  expect_refused("[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.125]", "[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0.125]",
                 {"sample.object_to_world.thing", "flat"});
  expect_refused("[0, 0, 1, 0.125], [0, 0, 0, 1]", "[0, 0, 1, 0.125], [0, 0, 1, 1]", {"last row"});
  expect_refused(
      "[[sample]]\nat = [0, 0]\nname = \"v00_p00\"\nradiance = \"rad_v00_p00.exr\"\ngeometry = "
      "\"geom_v00.exr\"\nobject_index = \"id_v00_p00.png\"",
      "[[sample]]\nat = [0, 0]\nname = \"v00_p00\"\nradiance = \"rad_v00_p00.exr\"\ngeometry = "
      "\"geom_v00.exr\"",
      {"no object_index", "\"thing\"", "no cryptomatte"});
}

TEST_F(AnimationJobTest, LayersFollowFromTheChannels) {
  make(false);
  const std::vector<float> plane(12, 0.5f);
  const auto layers_with = [&](const std::vector<std::string>& channels) {
    write_exr(folder_ / "rad_v00_p00.exr", 4, 3, {{"", channels, std::vector(channels.size(), plane), {}}});
    return job_for_folder(folder_.path()).layers;
  };
  EXPECT_EQ(layers_with({"R", "G", "B"}), (std::vector<AnimationLayer>{{"radiance", {""}, {"view", "light"}}}));
  EXPECT_EQ(layers_with({"glossy.R", "glossy.G", "glossy.B"}),
            (std::vector<AnimationLayer>{{"view_dependent", {"glossy"}, {"view", "light"}}}));
  expect_error(ErrorCode::kInput, {"rad_v00_p00.exr", "no channel diffuse.R", "Z"}, [&] { layers_with({"Z"}); });
}

TEST_F(AnimationJobTest, FoldersThatAreNotUnderstood) {
  expect_error(ErrorCode::kInput, {"none", "not a folder", "scene.json"}, [&] { job_for_folder(folder_ / "none"); });
  expect_folder_refused({"no scene.json", "folder of renders"});
  make(false);
  const std::string scene = read_bytes(folder_ / "scene.json");
  const auto expect_edit_refused = [&](const std::function<void(nlohmann::json&)>& edit,
                                       std::vector<std::string> parts) {
    edit_scene(edit);
    parts.push_back("scene.json");
    expect_folder_refused(parts);
    write_bytes(folder_ / "scene.json", scene);
  };
  expect_edit_refused([](auto& s) { s = 1; }, {"JSON object"});
  expect_edit_refused([](auto& s) { s.erase("width"); }, {"no \"width\""});
  expect_edit_refused([](auto& s) { s["views"] = -2; }, {"\"views\"", "-2", "integer"});
  expect_edit_refused([](auto& s) { s["params"] = 3; }, {"4 samples", "expected 6"});
  expect_edit_refused([](auto& s) { s["samples"] = 3; }, {"\"samples\"", "list of objects"});
  expect_edit_refused([](auto& s) { s["samples"][0]["name"] = 3; }, {"name", "sample", "3"});
  expect_edit_refused([](auto& s) { s["samples"][1].erase("projection"); }, {"v00_p01", "no \"projection\""});
  expect_edit_refused(
      [](auto& s) {
        s["samples"][1]["projection"][2] = {1, 2};
      },
      {"v00_p01", "projection", "not a matrix"});
  expect_edit_refused([](auto& s) { s["objects"] = nlohmann::json::object(); }, {"\"objects\"", "no objects"});
  edit_scene([](auto& s) { s["objects"]["cup"] = 1; });
  expect_folder_refused({"geometry.gltf", "no object \"cup\"", "thing"});
  write_bytes(folder_ / "scene.json", scene);
  edit_scene([](auto& s) { s["samples"][0]["object_to_world"]["thing"] = 1; });
  expect_folder_refused({"objects that move", "no id_v00_p00.png"});
  write_bytes(folder_ / "scene.json", scene);
  fs::remove(folder_ / "geom_v01.exr");
  expect_folder_refused({"no geom_v01.exr", "scene.json"});
  fs::remove(folder_ / "rad_v00_p01.exr");
  expect_folder_refused({"no rad_v00_p01.exr"});
  fs::remove(folder_ / "geometry.gltf");
  expect_folder_refused({"geometry.glb", "geometry.gltf", "geometry.obj"});
}

// Reads the example of docs/reference/animation_jobs.md. The test makes the files that the example names.
TEST_F(AnimationJobTest, TheDocumentedExampleIsRead) {
  make(false);
  const std::string page = read_bytes(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/animation_jobs.md");
  const std::size_t begin = page.find("```toml\n") + 8;
  std::string text = page.substr(begin, page.find("```", begin) - begin);
  const std::vector<float> plane(12, 0.5f);
  write_exr(folder_ / "room.exr", 4, 3,
            {{"",
              {"R", "G", "B", "Z", "CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b", "CryptoObject00.a"},
              std::vector(8, plane),
              {{"cryptomatte/1234567/name", "CryptoObject"}}}});
  replace_once(text, "room.glb", "room.gltf");
  GltfScene scene;
  scene.nodes = R"({"name":"floor","mesh":0})";
  write_bytes(folder_ / "room.gltf", gltf_text(scene));
  const AnimationJob job = read(text);
  EXPECT_EQ(job.radiance_max, 4.0);
  EXPECT_EQ(job.objects[0].texture.stretch_max, 1.5);
  EXPECT_EQ(job.objects[0].texture.wrap, "periodic");
  EXPECT_EQ(job.samples[0].name, "0");
}

TEST(AnimationJob, TheRealFieldIsUnderstood) {
  if (shared_field().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder with field_demo1";
  AnimationJob job = job_for_folder(shared_field());
  EXPECT_EQ(job.samples.size(), 64u);
  EXPECT_EQ(job.cameras.size(), 8u);
  EXPECT_EQ(job.objects.size(), 6u);
  EXPECT_EQ(job.parameters[1].name, "light");
  EXPECT_EQ(job.objects[5].name, "parfait");
  const TemporaryFolder folder;
  write_bytes(folder / "field.toml", animation_job_text(job, folder.path()));
  AnimationJob again = read_animation_job(folder / "field.toml");
  // Relative to another folder, paths may be spelled differently.
  EXPECT_TRUE(fs::equivalent(again.samples[9].radiance, job.samples[9].radiance));
  EXPECT_EQ(again.cameras, job.cameras);
  EXPECT_EQ(again.objects, job.objects);
  EXPECT_EQ(again.layers, job.layers);
}

}  // namespace
}  // namespace multum::testing
