// SPDX-License-Identifier: Apache-2.0
// Tests a sweep of settings: its page, its numbers and its Pareto fronts. Also tests that no temporary file remains.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/html/rendered_page.h"

namespace multum::testing {
namespace {

class TradeoffCommandTest : public CliTest {
 protected:
  TradeoffCommandTest() { make_map("map", 32); }
  std::vector<std::string> command(std::vector<std::string> options) {
    options.insert(options.begin(), {"tradeoff", path("map_normal.png"), "-o", path("costs.html"), "--green", "up",
                                     "--quick", "--no-pictures"});
    return options;
  }
};

bool has_more_error(const nlohmann::json& a, const nlohmann::json& b) {
  return a.at("relative_l1").get<double>() - b.at("relative_l1").get<double>() >
         std::hypot(a.at("confidence_95").get<double>(), b.at("confidence_95").get<double>());
}

// Returns whether another row beats this one: the other row must be at least as good in bytes and in error, and better
// in one of the two. Errors differ only if the difference exceeds both intervals.
bool is_beaten(const nlohmann::json& one, const nlohmann::json& rows) {
  return std::any_of(rows.begin(), rows.end(), [&](const nlohmann::json& other) {
    return other.at("gpu_bytes") <= one.at("gpu_bytes") && !has_more_error(other, one) &&
           (other.at("gpu_bytes") < one.at("gpu_bytes") || has_more_error(one, other));
  });
}

TEST_F(TradeoffCommandTest, WritesAPageWithItsFronts) {
  const ProgramResult swept = multum(command({"--report", path("costs.json"), "--markdown", path("costs.md"),
                                              "--target-error", "0.3", "--brdf", "blinn-phong:50"}));
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  EXPECT_EQ(folder_.names(),
            (std::set<std::string>{"map_normal.png", "map_albedo.png", "costs.html", "costs.json", "costs.md"}));
  const nlohmann::json json = nlohmann::json::parse(read_bytes(path("costs.json")));
  const nlohmann::json& rows = json.at("rows");
  ASSERT_GE(rows.size(), 10u);
  for (const nlohmann::json& one : rows) {
    EXPECT_GT(one.at("relative_l1").get<double>(), 0.0);
    EXPECT_GT(one.at("gpu_bytes").get<double>(), 0.0);
    EXPECT_NE(one.at("fronts").at("gpu_bytes").get<bool>(), is_beaten(one, rows)) << one;
  }
  const nlohmann::json& chosen = rows.at(json.at("chosen").get<std::size_t>());
  EXPECT_LE(chosen.at("relative_l1").get<double>() + chosen.at("confidence_95").get<double>(), 0.3);
  const std::string page = read_bytes(path("costs.html"));
  EXPECT_FALSE(contains(page, "src=\"http") || contains(page, "href=") || contains(page, "import "))
      << "the page must be complete without other files";
  // The page holds all data of the JSON.
  const nlohmann::json data = page_data(page);
  for (const auto& [key, value] : json.items()) EXPECT_EQ(data[key], value) << key;
  EXPECT_EQ(data["asked"], (nlohmann::json{{"error", 0.3}}));
  const std::optional<std::string> shown = rendered_page(page);
  if (!shown) GTEST_SKIP() << "no Chromium";
  EXPECT_TRUE(contains(*shown, chosen.at("command").get<std::string>())) << chosen.at("command");
  for (const char* part : {"<svg", "<polyline", "class=\"sortable\"", "For an error of 30 %", "</html>",
                           "accuracy costs: map_normal.png</h1>"})
    EXPECT_TRUE(contains(*shown, part)) << part;
  for (const char* part : {"NaN", "Infinity", "undefined", "null"}) EXPECT_FALSE(contains(*shown, part)) << *shown;
}

// For any file name, the page shows the name as text, and the command quotes it.
TEST_F(TradeoffCommandTest, AHostileNameStaysText) {
  const std::string name = "<script><img src=x onerror=\"document.title='mine'\">.png";
  std::filesystem::copy_file(path("map_normal.png"), path(name));
  const ProgramResult swept =
      multum({"tradeoff", path(name), "-o", path("costs.html"), "--green", "up", "--quick", "--no-pictures"});
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  const std::string page = read_bytes(path("costs.html"));
  EXPECT_EQ(page_data(page)["map"], name);
  EXPECT_FALSE(contains(page, "<img"));
  const std::optional<std::string> shown = rendered_page(page);
  if (!shown) GTEST_SKIP() << "no Chromium";
  EXPECT_FALSE(contains(*shown, "<img"));
  EXPECT_TRUE(contains(*shown, "<h1 id=\"title\">What accuracy costs: &lt;script&gt;&lt;img src=x")) << *shown;
}

// The page and the JSON mark the rows that meet all budgets, and the most accurate of these rows is chosen. Without
// level 0, more lobes fit into the budget. Trial bakes print no warnings to stderr.
TEST_F(TradeoffCommandTest, MarksWhatKeepsToBudgets) {
  // The slopes are so slight that the storage format cannot represent lobes as sharp as these. Each bake of lobes
  // prints a warning about this.
  TestImage slight{.width = 32, .height = 32, .channels = 3, .type = OIIO::TypeDesc::UINT16};
  for (int i = 0; i < 32 * 32; ++i)
    for (const double v : {0.004 * std::sin(0.7 * i), 0.004 * std::cos(1.9 * i), 1.0})
      slight.values.push_back(static_cast<float>(0.5 + 0.5 * v));
  write_test_image(path("slight.png"), slight);
  // With three lobes, all levels together take 3 * 8 bytes * 1365 texels.
  const std::uint64_t bytes_max = 33000;
  const auto sweep = [&](const std::string& map, std::vector<std::string> options) {
    options.insert(options.begin(), {"tradeoff", path(map), "-o", path("costs.html"), "--green", "up", "--quick",
                                     "--no-pictures", "--report", path("costs.json")});
    return multum(options);
  };
  const ProgramResult swept =
      sweep("map_normal.png", {"--max-bytes", std::to_string(bytes_max), "--max-bake-ms", "1e7"});
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  const nlohmann::json json = nlohmann::json::parse(read_bytes(path("costs.json")));
  EXPECT_EQ(json["budget"], (nlohmann::json{{"gpu_bytes", bytes_max}, {"bake_seconds", 1e4}}));
  double best = 1e9;
  std::size_t fitting = 0;
  std::map<std::pair<int, int>, std::uint64_t> bytes;  // indexed by the number of lobes and the first level
  for (const nlohmann::json& row : json["rows"]) {
    EXPECT_GT(row["bake_seconds"].get<double>(), 0.0) << row;
    EXPECT_GT(row["bake_processor_seconds"].get<double>(), 0.0) << row;
    EXPECT_EQ(row["bake_device_seconds"], 0.0) << "OpenCL runs on processors here";
    EXPECT_EQ(row["bake_work_seconds"], row["bake_processor_seconds"]) << row;
    EXPECT_EQ(row["fits"], row["gpu_bytes"].get<std::uint64_t>() <= bytes_max) << row;
    fitting += row["fits"].get<bool>() ? 1 : 0;
    if (row["fits"]) best = std::min(best, row["relative_l1"].get<double>());
    const std::string bake = row["bake"];
    // If a file lacks the finest level, renderers also need the normal map.
    const bool needs_map = bake.find("--first-level") != std::string::npos;
    EXPECT_EQ(row.value("normal_map_file_bytes", std::uint64_t{0}),
              needs_map ? std::filesystem::file_size(path("map_normal.png")) : 0u)
        << row;
    EXPECT_GT(row["file_bytes"].get<std::uint64_t>(), row.value("normal_map_file_bytes", std::uint64_t{0}));
    for (const int lobes : {2, 4})
      if (bake == fmt::format("--ndf vmf --lobes {} --first-level 1", lobes)) bytes[{lobes, 1}] = row["gpu_bytes"];
      else if (bake == fmt::format("--ndf vmf --lobes {}", lobes)) bytes[{lobes, 0}] = row["gpu_bytes"];
  }
  EXPECT_GT(fitting, 0u);
  EXPECT_LT(fitting, json["rows"].size());
  EXPECT_EQ(json["rows"].at(json["chosen"].get<std::size_t>())["relative_l1"], best);
  ASSERT_EQ(bytes.size(), 4u) << "two and four lobes, with level 0 and without";
  EXPECT_LT((bytes[{4, 1}]), (bytes[{2, 0}]));
  // For 32 x 32 texels, level 0 is the normal map: 64 blocks of BC5. The other levels have four lobes of 8 bytes per
  // texel.
  EXPECT_EQ((bytes[{4, 1}]), 64u * 16u + 4u * 8u * (256u + 64u + 16u + 4u + 1u));
  const std::string kept = fmt::format("{} of {} settings", fitting, json["rows"].size());
  expect_says(swept.out, {"within 0.03147 MiB on the GPU, 1e+07 ms of baking: " + kept, " MiB  ", "chosen: "});
  const std::string page = read_bytes(path("costs.html"));
  EXPECT_EQ(page_data(page)["fitting_count"], fitting);
  EXPECT_EQ(page_data(page)["setting_count"], json["rows"].size());
  if (const std::optional<std::string> shown = rendered_page(page)) {
    for (const char* part : {"<s><code>--ndf vmf --lobes 6</code></s>", "GPU, MiB", "mark over",
                             "0.03147 MiB on the GPU, 1e+07 ms of baking", "meet it"})
      EXPECT_TRUE(contains(*shown, part)) << part;
    EXPECT_FALSE(contains(*shown, "MB")) << "one unit of memory";
  }
  // No setting meets this budget. If no frames are drawn, no setting can meet a budget of frame time.
  EXPECT_EQ(sweep("map_normal.png", {"--max-bytes", "10"}).exit_code, kVerification);
  EXPECT_EQ(sweep("map_normal.png", {"--max-frame-ms", "10"}).exit_code, kUsage);
  const ProgramResult doubtful = sweep("slight.png", {});
  ASSERT_EQ(doubtful.exit_code, 0) << doubtful.err;
  EXPECT_FALSE(contains(doubtful.err, "warning")) << doubtful.err;
  std::size_t warned = 0;
  const nlohmann::json doubts = nlohmann::json::parse(read_bytes(path("costs.json")));
  for (const nlohmann::json& row : doubts["rows"]) warned += row.contains("warnings") ? 1 : 0;
  EXPECT_GT(warned, 0u) << "they are in the report";
}

// Settings are ranked by the measured pixel error. A difference that is smaller than both intervals does not count. If
// there is a roughness map, pictures are drawn with it, and the errors are those of the BRDF "roughness".
using TradeoffPictureTest = TradeoffCommandTest;  // slow: two pictures per setting

TEST_F(TradeoffPictureTest, RanksByErrorsBeyondTheirIntervalsWithRoughnessToo) {
  TestImage gloss{.width = 32, .height = 32, .channels = 1, .type = OIIO::TypeDesc::UINT8};
  for (int i = 0; i < 32 * 32; ++i) gloss.values.push_back(0.4f + 0.2f * std::sin(0.3f * static_cast<float>(i)));
  write_test_image(path("map_gloss.png"), gloss);
  const ProgramResult swept =
      multum({"tradeoff", path("map_normal.png"), "-o", path("costs.html"), "--green", "up", "--quick", "--gloss",
              path("map_gloss.png"), "--report", path("costs.json"), "--context", "osmesa", "--max-bytes", "1G"});
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  const nlohmann::json json = nlohmann::json::parse(read_bytes(path("costs.json")));
  const nlohmann::json& rows = json["rows"];
  EXPECT_EQ(json["brdf"], "roughness");
  EXPECT_TRUE(contains(rows[0]["command"], " --gloss map_gloss.png")) << rows[0]["command"];
  double best = 1e9;
  for (const nlohmann::json& one : rows) {
    EXPECT_NE(one["fronts"]["gpu_bytes"].get<bool>(), is_beaten(one, rows)) << one;
    EXPECT_GT(one["rendered_relative_l1"].get<double>(), 0.0) << one;
    EXPECT_GT(one["frame_ms"].get<double>(), 0.0) << one;
    EXPECT_GT(one["frame_work_ms"].get<double>(), 0.0) << one;
    best = std::min(best, one["relative_l1"].get<double>());
  }
  EXPECT_EQ(rows.at(json["chosen"].get<std::size_t>())["relative_l1"], best);
  const std::string count = fmt::format("{} settings", rows.size());
  EXPECT_TRUE(contains(swept.out, count + " in ")) << swept.out;
  const std::string page = read_bytes(path("costs.html"));
  EXPECT_EQ(page_data(page)["setting_count"], rows.size()) << "one number everywhere";
  if (const std::optional<std::string> shown = rendered_page(page)) {
    for (const char* part :
         {"<h2>Pictures</h2>", "<b>reference</b>", "src=\"data:image/png;base64,iVBOR", " %</b>: --ndf"})
      EXPECT_TRUE(contains(*shown, part)) << part;
  }
  EXPECT_EQ(multum(command({"--gloss", path("map_gloss.png"), "--brdf", "lambert"})).exit_code, kUsage);
  EXPECT_EQ(multum(command({"--gloss", path("map_gloss.png"), "--report", path("map_gloss.png")})).exit_code, kUsage);
}

TEST_F(TradeoffCommandTest, LeavesNothingWhenItIsInterrupted) {
  const std::string scratch = ".multum-partial-costs.html";
  // Files of a killed sweep do not disturb the next one.
  for (const int signal : {SIGKILL, SIGINT}) {
    Program program(multum_command(command({})));
    while (program.running() && !std::filesystem::exists(path(scratch + "/swept_0.ndf.exr")))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    program.send(signal);
    const ProgramResult result = program.wait();
    EXPECT_EQ(signal == SIGKILL ? result.signal : result.exit_code, signal == SIGKILL ? SIGKILL : 130) << result.err;
    EXPECT_EQ(folder_.names().contains(scratch), signal == SIGKILL);
    std::filesystem::remove(path(scratch + "/swept_0.ndf.exr"));  // This shows that the next setting has begun.
  }
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"map_normal.png", "map_albedo.png"}));
}

TEST_F(TradeoffCommandTest, SaysWhenNothingIsGoodEnough) {
  for (const std::vector<std::string>& options : std::vector<std::vector<std::string>>{
           {"--target-error", "0.1", "--budget-ms", "10"}, {"--brdf", "glass"}, {"--target-error", "-1"}})
    EXPECT_EQ(multum(command(options)).exit_code, 2) << options.front();
  EXPECT_EQ(multum({"tradeoff", path("missing.png"), "-o", path("costs.html"), "--quick"}).exit_code, 3);
  EXPECT_FALSE(folder_.names().contains("costs.html"));
}

}  // namespace
}  // namespace multum::testing
