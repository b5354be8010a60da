// SPDX-License-Identifier: Apache-2.0
// Tests bakes and exports of several maps, which run at the same time. Files, text and log must be the same as if the
// maps were handled one after another.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "tests/cli/program.h"
#include "tools/multum/map_turns.h"

namespace multum::testing {
namespace {

// Times differ from run to run, and only the first run compiles kernels.
std::string without_times(const std::string& text) {
  const std::string kept = std::regex_replace(text, std::regex("compiling kernels [^\n]*\n"), "");
  return std::regex_replace(kept, std::regex("[0-9.]+ s\\b"), "T");
}

class SeveralMapsTest : public CliTest {
 protected:
  // Maps of several sizes, in an order in which later ones are finished earlier. The fourth is not a picture.
  void SetUp() override {
    for (const int size : {128, 64, 16, 32, 16}) {
      make_map("m", size);
      inputs_.push_back(path("map_" + std::to_string(inputs_.size()) + ".png"));
      std::filesystem::rename(path("m_normal.png"), inputs_.back());
    }
    write_bytes(inputs_[3], "no picture");
  }
  std::vector<std::string> command(const std::string& folder, std::vector<std::string> options) const {
    std::filesystem::create_directory(path(folder));
    std::vector<std::string> words = {"bake", "-o", path(folder)};
    words.insert(words.end(), inputs_.begin(), inputs_.end());
    words.insert(words.end(), options.begin(), options.end());
    return words;
  }
  static std::map<std::string, std::string> files_of(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      files[entry.path().filename().string()] = read_bytes(entry.path().string());
    return files;
  }
  // Returns what a run prints, without the name of its folder.
  std::string shown(std::string text, const std::string& folder) const {
    for (const std::string& name : {path(folder) + "/", folder + "/"})
      for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) text.replace(at, name.size(), "");
    return without_times(text);
  }
  // Runs the manifest of all maps, whose outputs are in `folder`.
  ProgramResult run_manifest(const std::string& verb, const std::string& ending, const std::string& folder,
                             const std::string& threads) const {
    std::filesystem::create_directory(path(folder));
    std::string text;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      text += "[[map]]\ninput = \"" + inputs_[i] + "\"\noutput = \"" + path(folder + "/" + std::to_string(i) + ending) +
              "\"\n";
    write_bytes(path("maps.toml"), text);
    return multum({verb, "--manifest", path("maps.toml"), "--threads", threads});
  }
  // Compares the runs that wrote to the folders "single" and "several".
  void expect_same(const ProgramResult& single, const ProgramResult& several) const {
    EXPECT_EQ(single.exit_code, kInput) << single.err;
    EXPECT_EQ(several.exit_code, kInput) << several.err;
    EXPECT_EQ(shown(several.out, "several"), shown(single.out, "single"));
    EXPECT_EQ(shown(several.err, "several"), shown(single.err, "single"));
    EXPECT_TRUE(files_of(path("several")) == files_of(path("single")));
  }

  std::vector<std::string> inputs_;
};

TEST_F(SeveralMapsTest, ResultsAreThoseOfMapsOneAfterAnother) {
  const ProgramResult single = multum(command("single", {"--threads", "1"}));
  const ProgramResult several = multum(command("several", {"--threads", "3"}));
  expect_says(several.err, {"map_3.png", "5 maps: 4 baked, 0 unchanged, 1 failed"});
  expect_same(single, several);
  EXPECT_EQ(files_of(path("several")).size(), 4u);

  const ProgramResult json = multum(command("several", {"--threads", "3", "--json"}));
  const nlohmann::json maps = nlohmann::json::parse(json.out)["maps"];
  ASSERT_EQ(maps.size(), inputs_.size());
  for (std::size_t i = 0; i < maps.size(); ++i)
    EXPECT_EQ(maps[i]["source"], i == 3 ? inputs_[i] : std::filesystem::path(inputs_[i]).filename().string());
  EXPECT_TRUE(contains(json.err, "4 unchanged, 1 failed")) << json.err;
}

TEST_F(SeveralMapsTest, AManifestGivesTheSameResults) {
  const ProgramResult single = run_manifest("bake", ".ndf.exr", "single", "1");
  expect_same(single, run_manifest("bake", ".ndf.exr", "several", "3"));
  EXPECT_EQ(files_of(path("several")).size(), 4u);
}

// Exports of several maps write to one folder, in which an earlier unfinished export may remain.
TEST_F(SeveralMapsTest, ExportsAreThoseOfMapsOneAfterAnother) {
  const auto run = [&](const std::string& folder, std::vector<std::string> options) {
    std::vector<std::string> words = command(folder, std::move(options));
    words[0] = "export";
    return multum(words);
  };
  const ProgramResult single = run("single", {"--format", "ktx2", "--threads", "1"});
  const ProgramResult several = run("several", {"--format", "ktx2", "--threads", "3"});
  expect_says(several.err, {"map_3.png", "5 maps: 4 exported, 1 failed"});
  expect_same(single, several);
  EXPECT_EQ(files_of(path("several")).size(), 8u);

  EXPECT_EQ(run("small", {"--format", "ktx2", "--threads", "3", "--memory", "128M", "--resume"}).exit_code, kInput);
  EXPECT_TRUE(files_of(path("small")) == files_of(path("single")));
}

TEST_F(SeveralMapsTest, AManifestOfExportsGivesTheSameResults) {
  const ProgramResult single = run_manifest("export", ".ktx2", "single", "1");
  expect_same(single, run_manifest("export", ".ktx2", "several", "3"));
  const ProgramResult again = run_manifest("export", ".ktx2", "several", "3");
  expect_says(again.err, {"0 exported, 4 unchanged, 1 failed"});
}

TEST_F(SeveralMapsTest, LittleMemoryGivesTheSameFiles) {
  EXPECT_EQ(multum(command("single", {"--threads", "3", "--memory", "320M"})).exit_code, kInput);
  EXPECT_EQ(multum(command("several", {"--threads", "3", "--memory", "600M"})).exit_code, kInput);
  EXPECT_TRUE(files_of(path("several")) == files_of(path("single")));
}

TEST_F(SeveralMapsTest, TheBarCountsMaps) {
  if (!has_pseudo_terminals()) GTEST_SKIP() << "there are no pseudo terminals";
  const ProgramResult shown = run_on_terminal(multum_command(command("several", {"--threads", "2", "--no-measure"})));
  EXPECT_EQ(shown.exit_code, kInput);
  for (const char* part : {"\r\033[K[", "%  map 1 of 5", "%  map 2 of 5", "5 maps: 4 baked"})
    EXPECT_TRUE(contains(shown.out, part)) << part << shown.out;
}

// No file of an unfinished map remains. Maps that were finished before the signal stay, and are listed.
TEST_F(SeveralMapsTest, ASignalStopsAllMaps) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string folder = "out" + std::to_string(signal);
    Program bake(multum_command(command(folder, {"--threads", "3", "--no-measure"})));
    while (bake.running() && bake.err_so_far().find("map_0.png: 128 x 128") == std::string::npos)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    bake.send(signal);
    const ProgramResult result = bake.wait();
    if (result.exit_code != kInput) expect_refusal(result, 130, {"cancelled"});  // kInput: the bakes were faster
    for (const auto& [name, bytes] : files_of(path(folder))) {
      EXPECT_TRUE(name.ends_with(".ndf.exr") && !name.starts_with(".")) << name;
      EXPECT_EQ(multum({"verify", path(folder + "/" + name)}).exit_code, 0) << name;
      EXPECT_TRUE(contains(result.out, name + ": written")) << result.out;
    }
  }
}

// A signal may come when no map looks for it, for example while the sentence of a map is measured. The maps that remain
// are then not baked, so the command must not succeed. The test runs in its own process, because signals are
// remembered.
TEST(SeveralMapsDeathTest, ASignalThatNoMapNoticesIsNotLost) {
  EXPECT_EXIT(
      {
        Device device = Device::when_needed({});
        int worked = 0;
        try {
          for_each_map({3, 2, 2, {}}, {}, device, [&](const MapTurn&) {
            ++worked;
            raise(SIGINT);
          });
        } catch (const Cancelled&) {
          std::_Exit(10 + worked);
        }
        std::_Exit(0);
      },
      ::testing::ExitedWithCode(11), "");
}

}  // namespace
}  // namespace multum::testing
