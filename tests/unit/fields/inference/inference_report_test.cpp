// SPDX-License-Identifier: Apache-2.0
// Tests the report of `multum infer` on hand-made results. Means are weighted by pixels, held-out samples are reported
// separately, errors of frames leave out pixels that cannot be compared, and names cannot break the page.
#include "host/fields/inference/report/inference_report.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "host/fields/inference/report/inference_frames.h"
#include "host/fields/inference/report/inference_page.h"
#include "host/fields/inference/report/inference_pictures.h"
#include "tests/unit/foundation/base/test_folder.h"
#include "tests/unit/foundation/base/text_parts.h"
#include "tests/unit/foundation/html/rendered_page.h"

namespace multum {
namespace {

using testing::contains;
using testing::expect_error;
using testing::part_count;
using testing::TemporaryFolder;

constexpr const char* kOddName = "<b>&\"";
constexpr const char* kOddNameShown = "&lt;b&gt;&amp;\"";  // escaped as in the text that a browser serialises

// Holds a job of two views and three lights, with a vase of two layers, and an object with an odd name that no view
// sees.
struct ReportScene {
  AnimationJob job;
  AnimationInferSettings settings;
  AnimationInferResult result;
  InferenceFrames frames;
  InferenceComparison comparison;

  ReportScene() {
    job.path = "/somewhere/secret/job.toml";
    job.width = 8;
    job.height = 4;
    job.parameters = {{"view", 2, true}, {"light", 3, false}};
    job.layers = {{"diffuse", {"diffuse"}, {"light"}}, {"glossy", {"glossy"}, {"view", "light"}}};
    job.objects.resize(2);
    job.objects[0].name = "vase";
    job.objects[1].name = kOddName;
    for (int v = 0; v < 2; ++v)
      for (int p = 0; p < 3; ++p) {
        AnimationSample sample;
        sample.at = {v, p};
        sample.name = "v" + std::to_string(v) + "_p" + std::to_string(p);
        job.samples.push_back(sample);
      }
    result.blocks = {"all"};
    result.mappings = {{sized(148, 96)}, {sized(0, 0)}};
    result.textures = {texture({0, 3}, {10.0, 40.0}, {100.0, 50.0}, {20.0, 80.0}, {false, false}, 7),
                       texture({1, 4}, {1.0, 5.0}, {50.0, 100.0}, {2.0, 10.0}, {false, true}, 11)};
    result.textures[1].converged = false;
    TextureResult black;  // this sample has no figures and does not count
    black.layer = 1;
    black.samples = {2};
    black.is_held_out = {false};
    result.textures.push_back(black);
    frames.frames = {{0, "frames/v0_p0.exr", 4.0, 30.0, 2.0, 0.0, {6.0, 0.0}, {10.0, 0.0}},
                     {5, "frames/v1_p2.exr", 8.0, 10.0, 0.0, 1.0, {1.0, 0.0}, {30.0, 0.0}}};
    comparison = {"v0_p1", 4, {20.0, 0.0}, {{"bilinear <1>", {3.25, -1.0}}, {"trilinear", {4.5, -1.0}}}};
  }

  static TextureMapping sized(int width, int height) {
    TextureMapping mapping;
    mapping.width = width;
    mapping.height = height;
    return mapping;
  }

  static TextureResult texture(std::vector<int> samples, std::vector<double> errors, std::vector<double> pixels,
                               std::vector<double> forward, std::vector<bool> held_out, int iterations) {
    TextureResult one;
    one.samples = std::move(samples);
    one.squared_errors = std::move(errors);
    one.pixel_counts = std::move(pixels);
    one.forward_squared_errors = std::move(forward);
    one.is_held_out = std::move(held_out);
    one.file = "textures/vase/diffuse_" + std::to_string(iterations) + ".exr";
    one.iterations = iterations;
    one.history = {{iterations, 0.5, 1e-4, 3}};
    return one;
  }

  InferenceReport report() const { return {job, settings, result, 4, &frames, &comparison}; }
};

TEST(InferenceReport, MeansAreOfPixelsAndHeldOutOnesAreApart) {
  const ReportScene scene;
  const std::vector<LayerSummary> layers = summarise_layers(scene.report());
  ASSERT_EQ(layers.size(), 1u) << "black layers have no summary";
  const LayerSummary& one = layers[0];
  EXPECT_EQ(one.textures, 2);
  // (10 * 100 + 40 * 50 + 1 * 50) / 200; the unweighted mean of the three would be 17.
  EXPECT_DOUBLE_EQ(one.squared_error, 15.25);
  EXPECT_DOUBLE_EQ(one.pixel_count, 200.0);
  EXPECT_DOUBLE_EQ(one.forward_squared_error, 30.5);
  EXPECT_DOUBLE_EQ(one.held_out_squared_error, 5.0);
  EXPECT_DOUBLE_EQ(one.worst_squared_error, 40.0);
  EXPECT_EQ(one.worst_sample, 3);
  EXPECT_DOUBLE_EQ(one.iterations_median, 9.0);
  EXPECT_EQ(one.iterations_max, 11);
  EXPECT_EQ(one.not_converged, 1);
}

TEST(InferenceReport, IterationsOfTexturesThatWereThereAreNotKnown) {
  ReportScene scene;
  scene.result.textures[0].was_there = true;
  scene.result.textures[0].iterations = 0;
  EXPECT_DOUBLE_EQ(summarise_layers(scene.report())[0].iterations_median, 11.0);
  scene.result.textures[1].was_there = true;
  const nlohmann::json json = nlohmann::json::parse(inference_report_json(scene.report()));
  EXPECT_TRUE(json["objects"][0]["layers"][0]["iterations"].is_null());
}

TEST(InferenceReport, JsonHoldsTheFigures) {
  const ReportScene scene;
  const std::string text = inference_report_json(scene.report());
  EXPECT_EQ(text.find("secret"), std::string::npos) << "the report must not reveal the machine's folders";
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["job"], "job.toml");
  const nlohmann::json& layer = json["objects"][0]["layers"][0];
  EXPECT_EQ(layer["mse"], 15.25);
  EXPECT_EQ(layer["forward_mapping_mse"], 30.5);
  EXPECT_EQ(layer["ratio"], 0.5);
  EXPECT_EQ(layer["held_out"]["mse"], 5.0);
  EXPECT_EQ(layer["worst_sample"]["name"], "v1_p0");
  EXPECT_EQ(json["objects"][1]["name"], kOddName);
  EXPECT_TRUE(json["objects"][1]["layers"].empty());
  EXPECT_TRUE(json["objects"][1]["frames"]["mse"].is_null()) << "an unseen object has no error, not an error of 0";
  EXPECT_EQ(json["objects"][0]["frames"]["mse"], (6.0 * 10.0 + 1.0 * 30.0) / 40.0);
  EXPECT_EQ(json["frames"]["mse"], 5.0);
  EXPECT_EQ(json["frames"]["samples"][1]["not_finite_pixels"], 1.0);
  EXPECT_EQ(json["textures"].size(), 2u);
  EXPECT_EQ(json["textures"][1]["newton"][0]["held"], 3);
  EXPECT_EQ(json["comparison"]["rows"][0]["mse"]["vase"], 3.25);
  EXPECT_TRUE(json["comparison"]["rows"][0]["mse"][kOddName].is_null());
}

// In the figures per object, the names of objects are also keys.
void expect_documented(const nlohmann::json& json, const std::string& page, const std::set<std::string>& names) {
  if (json.is_object()) {
    for (const auto& [key, value] : json.items())
      EXPECT_TRUE(names.count(key) > 0 || page.find("`" + key + "`") != std::string::npos) << key;
  }
  if (!json.is_structured()) return;
  for (const nlohmann::json& value : json) expect_documented(value, page, names);
}

std::string reference_page(const std::string& name) {
  std::ifstream file(std::string(MULTUM_SOURCE_DIR) + "/docs/reference/" + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(InferenceReport, EveryKeyIsDocumented) {
  const std::string report = reference_page("inferred_textures.md"), job = reference_page("animation_jobs.md");
  const std::size_t begin = report.find("\n## report.json\n");
  ASSERT_NE(begin, std::string::npos);
  const std::size_t texture = job.find("`[texture]`"), parameter = job.find("`[[parameter]]` describes one");
  ASSERT_LT(texture, parameter);
  ASSERT_NE(parameter, std::string::npos);
  // An object's texture has the same keys as the job.
  expect_documented(nlohmann::json::parse(inference_report_json(ReportScene().report())),
                    report.substr(begin) + job.substr(texture, parameter - texture), {"vase", kOddName});
}

TEST(InferenceReport, WithoutFramesAndComparisonJsonSaysSo) {
  const ReportScene scene;
  const InferenceReport report = {scene.job, scene.settings, scene.result, 0};
  const nlohmann::json json = nlohmann::json::parse(inference_report_json(report));
  EXPECT_TRUE(json["frames"].is_null());
  EXPECT_TRUE(json["comparison"].is_null());
  const std::optional<std::string> shown = testing::rendered_page(inference_page(report, {}));
  if (!shown) GTEST_SKIP() << "no Chromium";
  EXPECT_TRUE(contains(*shown, "No frames"));
  EXPECT_FALSE(contains(*shown, "<svg"));
  EXPECT_FALSE(contains(*shown, "Comparison of settings"));
}

TEST(InferenceReport, TextHasALineForEachLayer) {
  const ReportScene scene;
  EXPECT_EQ(inference_report_text(scene.report()),
            "vase diffuse: MSE 15.2 (forward mapping 30.5), held out 5.0, 2 textures of 148 x 96, 1 not converged\n"
            "frames: MSE 5.0 over 2 samples, at most 8.0 (v1_p2)\n");
}

TEST(InferenceReport, BlocksHaveTheirOwnTextureCoordinates) {
  ReportScene scene;
  scene.result.blocks = {"view00-00", "view01-01"};
  scene.result.mappings = {{ReportScene::sized(148, 96), ReportScene::sized(9, 200)},
                           {ReportScene::sized(0, 0), ReportScene::sized(5, 6)}};
  scene.result.textures[1].block = 1;
  EXPECT_NE(inference_report_text(scene.report()).find(", 2 textures of 9 x 200 to 148 x 96,"), std::string::npos);
  const nlohmann::json json = nlohmann::json::parse(inference_report_json(scene.report()));
  EXPECT_EQ(json["blocks"][1], "view01-01");
  EXPECT_EQ(json["objects"][0]["mappings"][1]["width"], 9);
  EXPECT_TRUE(json["objects"][1]["mappings"][0].is_null());
  EXPECT_EQ(json["textures"][1]["block"], "view01-01");
  const std::optional<std::string> shown = testing::rendered_page(inference_page(scene.report(), {}));
  if (!shown) GTEST_SKIP() << "no Chromium";
  for (const char* part : {"9 \u00d7 200 to 148 \u00d7 96", ">view01-01</td>", "5 \u00d7 6", "not seen"})
    EXPECT_TRUE(contains(*shown, part)) << part;
}

TEST(InferenceReport, SamplesAreFoundByIndicesAndByName) {
  const ReportScene scene;
  EXPECT_EQ(sample_named(scene.job, "1,0"), 3);
  EXPECT_EQ(sample_named(scene.job, "v1_p0"), 3);
  EXPECT_EQ(middle_sample(scene.job), 4);
  expect_error(ErrorCode::kUsage, {"'2,0'", "0,0", "1,2", "v0_p0"}, [&] { sample_named(scene.job, "2,0"); });
}

TEST(InferencePage, HasEveryObjectAndEscapesNames) {
  const ReportScene scene;
  ReportPictures pictures;
  pictures.has_frame = true;
  const auto row = [](const std::string& name, int width, int height) {
    const auto one = [&](const char* what) { return ReportPicture{"report/" + name + what, width, height}; };
    return PictureRow{one("_a.png"), one("_b.png"), one("_c.png"), 2.0};
  };
  pictures.frame = row("frame", 320, 240);
  pictures.objects = {row("vase", 30, 60), row("odd", 5, 7)};
  pictures.textures = {{1, 0, {"report/t.png", 148, 96}}};
  const std::string page = inference_page(scene.report(), pictures);
  EXPECT_FALSE(contains(page, "secret"));
  EXPECT_FALSE(contains(page, "src=\"http")) << "refers to nothing outside";
  const nlohmann::json data = testing::page_data(page);
  EXPECT_EQ(data["objects"][1]["name"], kOddName);
  EXPECT_FALSE(data.contains("textures")) << "the page does not show thousands of textures";
  EXPECT_EQ(data["pictures"]["textures"][0]["picture"]["file"], "report/t.png");
  const std::optional<std::string> shown = testing::rendered_page(page);
  if (!shown) GTEST_SKIP() << "no Chromium";
  EXPECT_EQ(part_count(*shown, "<b>&amp;"), 0u);
  EXPECT_GE(part_count(*shown, kOddNameShown), 3u) << "the name is in a heading, a column and a row";
  EXPECT_TRUE(contains(*shown, "bilinear &lt;1&gt;"));
  EXPECT_EQ(part_count(*shown, "<img "), 10u);
  EXPECT_EQ(part_count(*shown, "<img "), part_count(*shown, "alt=\"") - part_count(*shown, "alt=\"\""))
      << "pictures without words";
  for (const char* src : {"report/frame_a.png", "report/vase_b.png", "report/odd_c.png", "report/t.png"})
    EXPECT_EQ(part_count(*shown, std::string("src=\"") + src), 1u) << src;
  EXPECT_TRUE(contains(*shown, "<td class=\"best\">3.25</td>"));
  EXPECT_FALSE(contains(*shown, "<td class=\"best\">4.50</td>"));
  for (const char* part : {"NaN", "undefined", "null", "[object"}) EXPECT_EQ(part_count(*shown, part), 0u) << part;
}

TEST(InferencePage, ASampleOfTheGridIsOneCell) {
  const ReportScene scene;
  const std::string page = inference_page(scene.report(), {});
  EXPECT_EQ(testing::page_data(page)["frames"]["samples"][1]["sample"], 5) << "the sample's place on the grid";
  const std::optional<std::string> shown = testing::rendered_page(page);
  if (!shown) GTEST_SKIP() << "no Chromium";
  // The whole frames have two samples, and so has the vase. No view sees the odd object, so it does not have a map.
  EXPECT_EQ(part_count(*shown, "<rect class=\"cell\""), 4u);
  EXPECT_TRUE(contains(*shown, "<title>v1_p2: MSE 8.00</title>"));
}

// The row has five pixels: a correct one, one that is wrong by one step, one that the GL does not cover, a NaN, and one
// that is partly covered.
TEST(InferenceFrames, PixelsThatCannotBeComparedAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> traced(15, 1.0f);
  RenderedFrame frame{5, 1, traced, {1.0f, 1.0f, 0.998f, 1.0f, 1.0f}};
  for (std::size_t c = 3; c < 6; ++c) frame.rgb[c] = 0.0f;  // 255 steps
  for (std::size_t c = 6; c < 9; ++c) frame.rgb[c] = 0.0f;  // also wrong, but not covered
  traced[10] = nan;
  frame.rgb[12] = 0.0f;  // a third of 255^2, in a pixel that belongs to no object
  const FrameErrors errors =
      compare_frame(traced, frame, {{1.0f, 1.0f, 1.0f, 1.0f, 0.5f}, std::vector<float>(5, 0.0f)});
  EXPECT_EQ(errors.pixel_count, 3.0);
  EXPECT_EQ(errors.uncovered_pixels, 1.0);
  EXPECT_EQ(errors.not_finite_pixels, 1.0);
  EXPECT_NEAR(errors.squared_error, (0.0 + 65025.0 + 65025.0 / 3.0) / 3.0, 0.01);
  ASSERT_EQ(errors.object_pixel_counts.size(), 2u);
  EXPECT_EQ(errors.object_pixel_counts[0], 2.0);
  EXPECT_NEAR(errors.object_squared_errors[0], 65025.0 / 2.0, 0.01);
  EXPECT_EQ(errors.object_pixel_counts[1], 0.0);
}

TEST(InferencePictures, TheErrorIsTwentyTimesTheDifferenceOfSrgbSteps) {
  Png8Image a{2, 1, 3, {10, 20, 30, 200, 0, 7}}, b{2, 1, 3, {12, 17, 30, 100, 12, 7}};
  EXPECT_EQ(error_image(a, b).interleaved, (std::vector<std::uint8_t>{40, 60, 0, 255, 240, 0}));
  // 0.214 is half of white in sRGB: 127.5 of 255.
  const Png8Image image = srgb_image({0.0f, 1.0f, 2.0f, -1.0f, std::nanf(""), 0.2159f}, 2, 1);
  EXPECT_EQ(image.interleaved, (std::vector<std::uint8_t>{0, 255, 255, 0, 0, 128}));
}

TEST(InferencePictures, CutsOutTheBoxOfAnObjectWithAMargin) {
  std::vector<float> coverage(20 * 12, 0.0f);
  coverage[10 * 20 + 3] = 1.0f;
  coverage[5 * 20 + 9] = 1.0f;
  coverage[0] = 0.9f;  // not whole
  const PixelBox box = covered_box(coverage, 20, 12);
  EXPECT_EQ(box.x, 0);  // 3 minus the margin of 4 is clamped to the edge of the picture
  EXPECT_EQ(box.y, 1);
  EXPECT_EQ(box.width, 14);
  EXPECT_EQ(box.height, 11);
  EXPECT_EQ(covered_box(std::vector<float>(20 * 12, 0.9f), 20, 12).width, 0);
  Png8Image image{20, 12, 3, std::vector<std::uint8_t>(3 * 20 * 12, 77)};
  const Png8Image cut = cut_out(image, coverage, box);
  ASSERT_EQ(cut.interleaved.size(), 4u * 14u * 11u);
  const std::size_t pixel = 4 * ((10 - 1) * 14 + 3);
  EXPECT_EQ(cut.interleaved[pixel], 77);
  EXPECT_EQ(cut.interleaved[pixel + 3], 255);
  EXPECT_EQ(cut.interleaved[pixel + 4], 0);
  EXPECT_EQ(cut.interleaved[pixel + 7], 0);
}

TEST(InferencePictures, PngHoldsWhatWasWrittenAlsoUnderAlpha) {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> values = {200, 100, 50, 255, 90, 60, 30, 128};
  write_png8(folder / "a.png", {2, 1, 4, values});
  OIIO::ImageSpec as_stored;
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  const auto in = OIIO::ImageInput::open(folder / "a.png", &as_stored);
  ASSERT_NE(in, nullptr);
  EXPECT_EQ(in->spec().width, 2);
  EXPECT_EQ(in->spec().height, 1);
  EXPECT_EQ(in->spec().nchannels, 4);
  EXPECT_EQ(in->spec().format, OIIO::TypeDesc(OIIO::TypeDesc::UINT8));
  std::vector<std::uint8_t> read(8, 1);
  ASSERT_TRUE(in->read_image(0, 0, 0, 4, OIIO::TypeDesc::UINT8, read.data()));
  EXPECT_EQ(read, values);
  EXPECT_EQ(folder.names().size(), 1u) << "temporary files";
}

}  // namespace
}  // namespace multum
