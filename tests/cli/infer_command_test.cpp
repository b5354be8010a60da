// SPDX-License-Identifier: Apache-2.0
// Tests multum infer, from a folder of ray-traced pictures to the pictures that OpenGL draws. Tests the results,
// omissions, the reuse of an earlier run, and refusals.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include <nlohmann/json.hpp>

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/image/files/exr_layers.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class InferCommandTest : public TracedSceneTest {
 protected:
  // Replaces a line of the job.
  void change_job(const std::string& from, const std::string& to) {
    std::string text = read_bytes(path("animation.toml"));
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write_bytes(path("animation.toml"), text.replace(at, from.size(), to));
  }
  InferredManifest manifest() const { return read_inferred_manifest(path("out/inferred.json")); }
  std::vector<std::string> textures() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(path("out/textures")))
      if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), path("out")).string());
    std::sort(names.begin(), names.end());
    return names;
  }
  // Returns the root mean square difference of the drawn and the ray-traced frame, in linear values, over pixels that
  // objects cover completely.
  double frame_error(const std::string& sample, const std::string& file) const {
    const std::string frame = path("frame.exr");
    const ProgramResult result = run_program({std::string(MULTUM_BIN_DIR) + "/multum-view", "sample", path("out"),
                                              "--at", sample, "-o", frame, "--context", "osmesa"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const ExrLayers drawn = read_exr_channels(frame, {"R", "G", "B", "A"});
    const ExrLayers traced = read_exr_channels(path("renders/" + file), {"R", "G", "B"});
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < drawn.channels.at("A").size(); ++i) {
      if (drawn.channels.at("A")[i] < 0.999f) continue;
      for (const char* c : {"R", "G", "B"}) {
        const double difference = static_cast<double>(drawn.channels.at(c)[i] - traced.channels.at(c)[i]);
        sum += difference * difference;
        count += 1.0;
      }
    }
    EXPECT_GT(count, 1000.0);
    return std::sqrt(sum / count);
  }
};

TEST_F(InferCommandTest, FramesLookAsTheyWereTraced) {
  write_scene({});
  const ProgramResult result = infer({});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  // The resolution of the textures is limited to 1.25 pixels per texel, which blurs the finest waves.
  EXPECT_LT(frame_error("0,0", "rad_v00_p00.exr"), 0.01);
  EXPECT_LT(frame_error("v01_p01", "rad_v01_p01.exr"), 0.01);
  // The ground has no view-dependent layer. Its diffuse layer is solved once for all views.
  EXPECT_EQ(textures(),
            (std::vector<std::string>{
                "textures/board/diffuse_light00.exr", "textures/board/diffuse_light01.exr",
                "textures/board/view_dependent_view00_light00.exr", "textures/board/view_dependent_view00_light01.exr",
                "textures/board/view_dependent_view01_light00.exr", "textures/board/view_dependent_view01_light01.exr",
                "textures/ground/diffuse_light00.exr", "textures/ground/diffuse_light01.exr"}));
  for (const InferredObject& object : manifest().objects)
    EXPECT_EQ(object.layers.size(), object.name == "board" ? 2u : 1u) << object.name;
  const FilterMatrix matrix = read_filter_matrix(path("out/matrices/v00_p00_ground.fmx"));
  EXPECT_LE(matrix.rows_rejected, matrix.row_count() / 1000);
  // With every sampler, the error of inference is at most half that of forward mapping.
  std::map<std::string, double> ground;
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path("out/report.json")));
  for (const auto& row : report["comparison"]["rows"]) ground[row["name"]] = row["mse"]["ground"];
  EXPECT_EQ(ground.size(), 14u);
  for (const std::string name :
       {"trilinear, one sample per pixel", "anisotropic, one sample per pixel", "trilinear, 4 x 4 sub-pixels"})
    EXPECT_LT(ground.at(name), 0.5 * ground.at("forward mapping, " + name)) << name;
}

// Each pair of views has its own texture coordinates and its own textures.
TEST_F(InferCommandTest, BlocksOfViewsAreInferredApartAndDrawnTogether) {
  TracedScene scene;
  scene.views = 3;
  scene.lights = 1;
  write_scene(scene);
  change_job("view = true  # moves the camera\nblock = 0", "view = true\nblock = 2");
  const ProgramResult result = infer({"--report-sample", "2,0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(frame_error("0,0", "rad_v00_p00.exr"), 0.01);
  EXPECT_LT(frame_error("1,0", "rad_v01_p00.exr"), 0.01);
  EXPECT_LT(frame_error("2,0", "rad_v02_p00.exr"), 0.01);
  EXPECT_EQ(textures(),
            (std::vector<std::string>{
                "textures/board/diffuse_view00-01_light00.exr", "textures/board/diffuse_view02-02_light00.exr",
                "textures/board/view_dependent_view00_light00.exr", "textures/board/view_dependent_view01_light00.exr",
                "textures/board/view_dependent_view02_light00.exr", "textures/ground/diffuse_view00-01_light00.exr",
                "textures/ground/diffuse_view02-02_light00.exr"}));
  for (const InferredObject& object : manifest().objects) {
    SCOPED_TRACE(object.name);
    EXPECT_EQ(object.mapping_of_sample, (std::vector<int>{0, 0, 1}));
    ASSERT_EQ(object.mappings.size(), 2u);
    EXPECT_NE(object.mappings[0].linear, object.mappings[1].linear);
    const std::vector<std::string>& files = object.layers[0].textures;
    EXPECT_EQ(files[0], files[1]);
    const InferredTexture last = read_inferred_texture(path("out/" + files[2]));
    EXPECT_EQ(last.width, object.mappings[1].width);
    EXPECT_EQ(last.height, object.mappings[1].height);
  }
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path("out/report.json")));
  EXPECT_EQ(report["blocks"], (std::vector<std::string>{"view00-01", "view02-02"}));
  // Textures of a run with different blocks are not reused.
  change_job("block = 2", "block = 1");
  ASSERT_EQ(infer({"--no-frames", "--no-comparison"}).exit_code, 0);
  EXPECT_EQ(manifest().objects[0].mapping_of_sample, (std::vector<int>{0, 1, 2}));
  EXPECT_LT(frame_error("1,0", "rad_v01_p00.exr"), 0.01);
}

TEST_F(InferCommandTest, GoesOnWhereItWasAndBytesAreTheSame) {
  write_scene({});
  ASSERT_EQ(infer({"--no-frames", "--no-comparison"}).exit_code, 0);
  const std::string kept = path("out/textures/ground/diffuse_light00.exr");
  const std::string lost = path("out/textures/board/diffuse_light01.exr");
  const std::string before = read_bytes(lost);
  const auto kept_time = fs::last_write_time(kept);
  fs::remove(lost);
  write_bytes(path("out/matrices/v01_p00_board.fmx"), "damaged");
  // This texture file is truncated but still has its keys.
  const std::string cut = path("out/textures/board/diffuse_light00.exr"), whole = read_bytes(cut);
  write_bytes(cut, whole.substr(0, whole.size() - 100));
  const std::string cut_matrix = path("out/matrices/v00_p00_board.fmx"), whole_matrix = read_bytes(cut_matrix);
  write_bytes(cut_matrix, whole_matrix.substr(0, whole_matrix.size() - 100));
  const ProgramResult again = infer({"--no-frames", "--no-comparison"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("diffuse_light00.exr"), std::string::npos) << again.err;
  EXPECT_NE(again.err.find("v00_p00_board.fmx"), std::string::npos) << again.err;
  EXPECT_EQ(read_bytes(cut), whole);
  EXPECT_EQ(read_bytes(cut_matrix), whole_matrix);
  EXPECT_EQ(fs::last_write_time(kept), kept_time);
  EXPECT_EQ(read_inferred_texture(lost).texels.size() > 0, true);
  EXPECT_EQ(read_bytes(lost), before);
  // After a change of this setting, everything that depends on it is inferred again.
  change_job("pyramid_weight = 0.1", "pyramid_weight = 0.5");
  ASSERT_EQ(infer({"--no-frames", "--no-comparison"}).exit_code, 0);
  EXPECT_NE(fs::last_write_time(kept), kept_time);
}

// The run is first interrupted, and later killed, when some of the 24 textures are finished. A texture takes some
// milliseconds, and so does the check whether it is finished.
TEST_F(InferCommandTest, AKilledRunLeavesNothingHalfWrittenAndIsGoneOnWith) {
  TracedScene scene;
  scene.lights = 6;
  write_scene(scene);
  constexpr std::size_t kTextures = 24;  // per light, the ground has one texture; the board has one, and one more per
                                         // view
  // Counts finished textures. A file that a killed program was still writing is not counted, because it does not have
  // its final name yet.
  const auto named_textures = [&] {
    std::vector<std::string> names;
    if (fs::exists(path("out/textures"))) names = textures();
    std::erase_if(names, [](const std::string& name) { return fs::path(name).filename().string().starts_with("."); });
    return names;
  };
  std::map<std::string, fs::file_time_type> kept;
  for (const int signal : {SIGINT, SIGKILL}) {
    SCOPED_TRACE(signal);
    const std::size_t before = kept.size();
    Program running(multum_command(
        {"infer", path("animation.toml"), "-o", path("out"), "--context", "osmesa", "--no-frames", "--no-comparison"}));
    for (int i = 0; i < 30000 && named_textures().size() <= before && running.running(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    running.send(signal);
    const ProgramResult stopped = running.wait();
    EXPECT_EQ(stopped.exit_code, signal == SIGINT ? 130 : -1) << stopped.err;
    EXPECT_EQ(stopped.signal, signal == SIGINT ? 0 : SIGKILL);
    EXPECT_FALSE(fs::exists(path("out/inferred.json")));
    if (signal == SIGINT) {
      EXPECT_EQ(textures(), named_textures()) << "a file is half-written";
    }
    for (const std::string& texture : named_textures()) {
      EXPECT_NO_THROW(read_inferred_texture(path("out/" + texture))) << texture;
      const auto time = fs::last_write_time(path("out/" + texture));
      EXPECT_EQ(kept.emplace(texture, time).first->second, time) << texture << " was made again";
    }
    EXPECT_GT(kept.size(), before);
    EXPECT_LT(kept.size(), kTextures) << "the run ended before the signal";
  }
  ASSERT_EQ(infer({"--no-frames", "--no-comparison"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(path("out/inferred.json")));
  for (const auto& [texture, time] : kept) EXPECT_EQ(fs::last_write_time(path("out/" + texture)), time) << texture;
  EXPECT_EQ(named_textures().size(), kTextures);
}

// Ctrl-C on a terminal also reaches multum-view. Then it is not a failure that multum-view ends.
TEST_F(InferCommandTest, CancelledWhileTheViewerRunsIsCancelled) {
  write_scene({});
  // This viewer exits as if Ctrl-C had been pressed, and sends multum the signal that the terminal would send.
  fs::create_directory(path("bin"));
  for (const char* program : {"multum", "multum-decode", "multum-decode-libraries.so"})
    fs::copy_file(std::string(MULTUM_BIN_DIR) + "/" + program, path("bin/") + program);
  write_bytes(path("bin/multum-view"), "#!/bin/sh\nkill -INT $PPID\nkill -INT $$\n");
  fs::permissions(path("bin/multum-view"), fs::perms::owner_all);
  const ProgramResult result = run_program({path("bin/multum"), "infer", path("animation.toml"), "-o", path("out")});
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(result.err.find("failed"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(path("out/inferred.json")));
}

// If the viewer crashes, multum survives and reports the viewer's output.
TEST_F(InferCommandTest, AViewerThatCrashesIsAnErrorThatSaysSo) {
  write_scene({});
  fs::create_directory(path("bin"));
  for (const char* program : {"multum", "multum-decode", "multum-decode-libraries.so"})
    fs::copy_file(std::string(MULTUM_BIN_DIR) + "/" + program, path("bin/") + program);
  write_bytes(path("bin/multum-view"), "#!/bin/sh\necho the driver is unwell\nkill -SEGV $$\n");
  fs::permissions(path("bin/multum-view"), fs::perms::owner_all);
  expect_refusal(run_program({path("bin/multum"), "infer", path("animation.toml"), "-o", path("out")}), kEnvironment,
                 {"pose 'v00_p00'", "signal 11", "the driver is unwell"});
}

TEST_F(InferCommandTest, PixelsThatAreNoNumbersAreRepairedAndCounted) {
  TracedScene scene;
  scene.has_bad_pixels = true;
  scene.has_depth_holes = true;
  write_scene(scene);
  const ProgramResult result = infer();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(frame_error("0,1", "rad_v00_p01.exr"), 0.01);
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path("out/report.json")));
  // Two pixels of each of the four pictures are not finite.
  EXPECT_EQ(report["segmentation"]["not_finite_pixels"], 8) << report["segmentation"];
  EXPECT_EQ(report["segmentation"]["repaired_pixels"], 8);
  EXPECT_GT(report["nan_depths"], 0);
}

// Such images do not say how much of a pixel an object covers, so multum computes the coverage from the geometry.
// Otherwise the board's gloss would also appear on the ground in pixels that show both objects.
TEST_F(InferCommandTest, ObjectIndexImagesAreUnmixedByTheGeometry) {
  TracedScene scene;
  scene.has_object_index = true;
  write_scene(scene);
  ASSERT_NE(read_bytes(path("animation.toml")).find("object_index = "), std::string::npos);
  const ProgramResult result = infer();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(frame_error("0,0", "rad_v00_p00.exr"), 0.01);
  for (const InferredObject& object : manifest().objects)
    EXPECT_EQ(object.layers.size(), object.name == "board" ? 2u : 1u) << object.name;
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path("out/report.json")));
  EXPECT_GT(report["segmentation"]["mixed_pixels"], 100);
}

TEST_F(InferCommandTest, AnObjectThatIsNeverSeenIsSaidAndLeftOut) {
  TracedScene scene;
  scene.has_hidden_object = true;
  write_scene(scene);
  const ProgramResult result = infer({"--no-frames", "--no-comparison"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_says(result.err, {"no picture shows", "'hidden'"});
  EXPECT_FALSE(fs::exists(path("out/textures/hidden")));
}

// For layers that do not depend on views, the second view's pictures are held out.
TEST_F(InferCommandTest, HeldOutViewsAreReported) {
  TracedScene scene;
  scene.lights = 1;
  write_scene(scene);
  const ProgramResult result = infer({"--no-frames", "--no-comparison", "--hold-out", "2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json provenance =
      nlohmann::json::parse(read_texture_provenance(path("out/textures/ground/diffuse_light00.exr")));
  EXPECT_EQ(provenance["samples"], (std::vector<std::string>{"v00_p00"}));
  const nlohmann::json report = nlohmann::json::parse(std::ifstream(path("out/report.json")));
  EXPECT_EQ(report["settings"]["hold_out"], 2);
  double squares = 0.0, pixels = 0.0;
  for (const auto& object : report["objects"])
    for (const auto& layer : object["layers"]) {
      SCOPED_TRACE(object["name"].get<std::string>() + ", " + layer["name"].get<std::string>());
      if (layer["name"] != "diffuse") {
        EXPECT_TRUE(layer["held_out"].is_null()) << "the layer depends on the view";
        continue;
      }
      ASSERT_TRUE(layer["held_out"].is_object());
      const double held_out = layer["held_out"]["mse"], count = layer["held_out"]["pixels"];
      EXPECT_GT(held_out, 2.0 * layer["mse"].get<double>()) << "as if it had been solved for";
      EXPECT_NEAR(count / layer["pixels"].get<double>(), 1.0, 0.1);
      squares += held_out * count;
      pixels += count;
    }
  // The picture drawn from the held-out view has an error of 0.0034, whereas the report states 0.0043, because only
  // pixels that objects cover completely are compared here. The solved views have a tenth of this error.
  const double drawn = frame_error("v01_p00", "rad_v01_p00.exr");
  EXPECT_NEAR(drawn / (std::sqrt(squares / pixels) / 255.0), 0.8, 0.2);
  EXPECT_LT(frame_error("v00_p00", "rad_v00_p00.exr"), 0.2 * drawn);
  for (const auto& texture : report["textures"])
    for (const auto& sample : texture["samples"]) {
      const bool is_held_out = texture["layer"] == "diffuse" && sample["name"] == "v01_p00";
      EXPECT_EQ(sample["held_out"], is_held_out) << texture["file"];
      EXPECT_GT(sample["mse"], 0.0) << "found nothing to compare";
    }
}

TEST_F(InferCommandTest, Refusals) {
  write_scene({});
  const std::string job = read_bytes(path("animation.toml"));
  const auto with = [&](const std::string& from, const std::string& to) {
    write_bytes(path("animation.toml"), job);
    change_job(from, to);
    return infer();
  };
  expect_refusal(with("passes = [\"diffuse\"]", "passes = [\"diffus\"]"), kInput, {"diffus", "rad_v00_p00.exr"});
  expect_refusal(with("width = 96", "width = 95"), kInput, {"95"});
  write_bytes(path("animation.toml"), job);
  expect_refusal(multum({"infer", path("none.toml"), "-o", path("out")}), kInput, {"none.toml"});
  expect_refusal(multum({"infer", path("animation.toml")}), kUsage, {"--output"});
  expect_refusal(infer({"--hold-out", "1"}), kUsage, {"--hold-out"});
  write_bytes(path("file"), "");
  expect_refusal(multum({"infer", path("animation.toml"), "-o", path("file/out")}), kEnvironment, {"file"});
  const std::string radiance = path("renders/rad_v01_p00.exr");
  const std::string bytes = read_bytes(radiance);
  write_bytes(radiance, bytes.substr(0, bytes.size() / 2));
  expect_refusal(infer(), kInput, {"rad_v01_p00.exr"});
  EXPECT_FALSE(fs::exists(path("out/inferred.json"))) << "an incomplete result must have no manifest";
}

TEST_F(InferCommandTest, CamerasThatDisagreeWithThePicturesAreRefused) {
  TracedScene scene;
  scene.camera_shift = 0.3;
  write_scene(scene);
  expect_refusal(infer(), kInput, {"v00_p00", "depth"});
  EXPECT_FALSE(fs::exists(path("out/textures")));
}

}  // namespace
}  // namespace multum::testing
