// SPDX-License-Identifier: Apache-2.0
// Tests multum export --resume: a stopped export continues after its last fitted row and writes the same bytes.
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/foundation/base/files/content_hash.h"
#include "tests/cli/program.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kSomeRecords = 3'000'000;  // in bytes; the whole work takes about 10 MB

class ExportResumeTest : public CliTest {
 protected:
  void SetUp() override {
    CliTest::SetUp();
    make_map("map", 1024);
    ASSERT_EQ(run_program(command("whole", {})).exit_code, 0);
    whole_ = hashes("whole");
  }

  // Exports the map in several bands of rows.
  std::vector<std::string> command(const std::string& folder, const std::vector<std::string>& more) const {
    std::vector<std::string> arguments = {"export",  path("map_normal.png"), "-o",           path(folder), "--memory",
                                          "16M",     "--base-roughness",     "0.25",         "--green",    "up",
                                          "--quiet", "--anisotropy",         "--no-measure", "--format",   "ktx2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum_command(arguments);
  }
  std::map<std::string, std::string> hashes(const std::string& folder) const {
    std::map<std::string, std::string> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(path(folder)))
      if (entry.is_regular_file()) found[entry.path().filename().string()] = hash_file(entry.path().string());
    return found;
  }
  std::string fits() const { return path("out/.multum-partial-export/fits"); }
  // Stops an export after it has fitted some rows.
  void stop_an_export(int signal) const {
    Program stopped(command("out", {"--resume"}));
    std::error_code none;
    while (stopped.running() && !(fs::exists(fits()) && fs::file_size(fits(), none) > kSomeRecords))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stopped.send(signal);
    const ProgramResult result = stopped.wait();
    if (signal == SIGTERM) {
      ASSERT_EQ(result.exit_code, 130) << result.err;
      EXPECT_TRUE(hashes("out").empty());
    } else {
      ASSERT_EQ(result.signal, signal) << "the export ended before the kill";
    }
    ASSERT_TRUE(fs::exists(fits()));
  }
  std::uint64_t rows_resumed(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> options = {"--resume", "--report", path("report.json")};
    options.insert(options.end(), more.begin(), more.end());
    const ProgramResult result = run_program(command("out", options));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    std::ifstream in(path("report.json"));
    return nlohmann::json::parse(in).at("rows_resumed").get<std::uint64_t>();
  }

  std::map<std::string, std::string> whole_;
};

TEST_F(ExportResumeTest, AStoppedExportGoesOnBehindItsRows) {
  for (const int signal : {SIGTERM, SIGKILL}) {
    stop_an_export(signal);
    EXPECT_GT(rows_resumed(), 0u);
    EXPECT_EQ(hashes("out"), whole_);
    EXPECT_FALSE(fs::exists(path("out/.multum-partial-export")));
    fs::remove_all(path("out"));
  }
}

TEST_F(ExportResumeTest, RowsThatAreDamagedOrOfOtherSettingsAreFittedAgain) {
  stop_an_export(SIGKILL);
  {
    std::fstream file(fits(), std::ios::in | std::ios::out | std::ios::binary);
    std::string key;
    std::getline(file, key);
    file.seekp(static_cast<std::streamoff>(key.size()) + 5000);
    file << "no lobes";
  }
  rows_resumed();
  EXPECT_EQ(hashes("out"), whole_);
  fs::remove_all(path("out"));

  stop_an_export(SIGKILL);
  std::ofstream(fits(), std::ios::app | std::ios::binary) << "half a record";
  EXPECT_GT(rows_resumed(), 0u);
  EXPECT_EQ(hashes("out"), whole_);
  fs::remove_all(path("out"));

  stop_an_export(SIGKILL);
  EXPECT_EQ(rows_resumed({"--fast"}), 0u);
  EXPECT_NE(hashes("out"), whole_);
}

TEST_F(ExportResumeTest, WithoutTheOptionNothingIsKept) {
  stop_an_export(SIGKILL);
  ASSERT_EQ(run_program(command("out", {})).exit_code, 0);
  EXPECT_EQ(hashes("out"), whole_);
  EXPECT_FALSE(fs::exists(path("out/.multum-partial-export")));
}

}  // namespace
}  // namespace multum::testing
