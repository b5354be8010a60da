// SPDX-License-Identifier: Apache-2.0
// A sweep of settings: its page, its figures, its fronts, and that nothing stays behind.
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/cli/program.h"
#include "tests/unit/image_test_files.h"

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

TEST_F(TradeoffCommandTest, WritesAPageWithItsFronts) {
  const ProgramResult swept = multum(command({"--json", path("costs.json"), "--markdown", path("costs.md"),
                                              "--target-error", "0.3", "--brdf", "blinn-phong:50"}));
  ASSERT_EQ(swept.exit_code, 0) << swept.err;
  EXPECT_EQ(folder_.names(),
            (std::set<std::string>{"map_normal.png", "map_albedo.png", "costs.html", "costs.json", "costs.md"}));
  const nlohmann::json json = nlohmann::json::parse(read_bytes(path("costs.json")));
  const nlohmann::json& rows = json.at("rows");
  ASSERT_GE(rows.size(), 10u);
  // On a front: no other is better in both. Off it: another is at least as good in both.
  for (const nlohmann::json& one : rows) {
    EXPECT_GT(one.at("relative_l1").get<double>(), 0.0);
    EXPECT_GT(one.at("gpu_bytes").get<double>(), 0.0);
    bool is_beaten = false;
    for (const nlohmann::json& other : rows) {
      const bool no_worse =
          other.at("gpu_bytes") <= one.at("gpu_bytes") && other.at("relative_l1") <= one.at("relative_l1");
      const bool better =
          other.at("gpu_bytes") < one.at("gpu_bytes") || other.at("relative_l1") < one.at("relative_l1");
      is_beaten = is_beaten || (no_worse && better);
    }
    EXPECT_NE(one.at("fronts").at("gpu_bytes").get<bool>(), is_beaten) << one;
  }
  const nlohmann::json& chosen = rows.at(json.at("chosen").get<std::size_t>());
  EXPECT_LE(chosen.at("relative_l1").get<double>() + chosen.at("confidence_95").get<double>(), 0.3);
  const std::string page = read_bytes(path("costs.html"));
  EXPECT_TRUE(contains(page, chosen.at("command").get<std::string>())) << chosen.at("command");
  for (const char* part : {"<svg", "<polyline", "class=\"sortable\"", "For an error of 30 %", "</html>"})
    EXPECT_TRUE(contains(page, part)) << part;
  EXPECT_FALSE(contains(page, "http://") || contains(page, "https://")) << "the page is whole by itself";
  EXPECT_FALSE(contains(page, "nan") || contains(page, "inf\"")) << page;
}

TEST_F(TradeoffCommandTest, LeavesNothingWhenItIsInterrupted) {
  Program program(multum_command(command({})));
  while (program.running() && folder_.names().count("costs.html.sweep") == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  program.send(SIGINT);
  const ProgramResult result = program.wait();
  EXPECT_EQ(result.exit_code, 130) << result.err;
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
