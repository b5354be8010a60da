// SPDX-License-Identifier: Apache-2.0
// Runs every command with small limits, which the shell sets (ulimit -f, -v, -n). Each command either succeeds, or says
// what is missing and exits with the code for faults of the machine. No signal terminates the command, and no
// half-written file is left.

#include "host/foundation/base/processes/sanitizers.h"
#include "tests/cli/program.h"
#include "tests/fixtures/sweeps.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class LimitSweepTest : public CliTest {
 protected:
  void SetUp() override {
    make_map("map", 32);
    ASSERT_EQ(multum({"bake", map(), "-o", path("movmf.ndf.exr"), "-q", "--no-measure"}).exit_code, 0);
    ASSERT_EQ(
        multum({"bake", map(), "-o", path("moments.ndf.exr"), "-q", "--no-measure", "--ndf", "moments"}).exit_code, 0);
    fs::copy_file(map(), path("other.png"));
    write_bytes(path("maps.toml"), "[[map]]\ninput = \"map_normal.png\"\noutput = \"out/a.ndf.exr\"\n");
    write_bytes(path("exports.toml"), "[[map]]\ninput = \"map_normal.png\"\noutput = \"out/a\"\n");
    write_bytes(path("scene.toml"),
                "[[map]]\nname = \"wall\"\nnormal = \"map_normal.png\"\n[[material]]\nname = \"paint\"\nbrdf = "
                "\"lambert\"\n[[object]]\nname = \"wall\"\nmap = \"wall\"\nmaterial = \"paint\"\nwidth = 1\n"
                "distance = [1, 2]\n[[light]]\ndirection = [0, 0, 1]\n");
    write_bytes(path("model.gltf"),
                R"({"asset": {"version": "2.0"}, "images": [{"uri": "map_normal.png"}], "textures": [{"source": 0}],
                    "materials": [{"name": "a", "normalTexture": {"index": 0}}]})");
  }

  std::string map() const { return path("map_normal.png"); }
  std::string out(const std::string& name) const { return path("out/" + name); }
  static std::string program(const std::string& name) { return std::string(MULTUM_BIN_DIR) + "/" + name; }

  // The commands write into the folder "out".
  std::vector<std::vector<std::string>> commands() const {
    const std::string multum = program("multum"), view = program("multum-view");
    std::vector<std::vector<std::string>> all = {
        {multum, "bake", map(), "-o", out("a.ndf.exr")},
        {multum, "bake", map(), "-o", out("a.ndf.exr"), "--ndf", "moments", "--report", out("a.json")},
        {multum, "bake", map(), path("other.png"), "-o", path("out")},
        {multum, "bake", "--manifest", path("maps.toml"), "--junit", out("a.xml")},
        {multum, "export", map(), "-o", out("a")},
        {multum, "export", map(), "-o", out("a"), "--format", "ktx2", "--zstd", "3"},
        {multum, "export", "--manifest", path("exports.toml")},
        {multum, "gltf", path("model.gltf"), "-o", out("a.glb"), "--format", "rgba8"},
        {multum, "plan", path("scene.toml")},
        {multum, "info", path("movmf.ndf.exr")},
        {multum, "verify", path("movmf.ndf.exr")},
        {multum, "devices", "--report", out("a.json")},
        {multum, "testmap", out("a"), "--size", "64"},
        {multum, "mip", path("map_albedo.png"), "-o", out("a.exr")},
        {multum, "materials", path("model.gltf"), "-o", out("a")},
        {multum, "parameters"},
        {multum, "shaders", "-o", out("a")},
        {multum, "look", path("movmf.ndf.exr"), "-o", out("a.html")},
        {view, path("movmf.ndf.exr"), "-o", out("a.png"), "--size", "32x32"},
        {view, path("moments.ndf.exr"), "-o", out("a.png"), "--size", "32x32"}};
    if (has_command("openjd"))
      all.push_back({multum, "openjd", "-o", out("a"), "bake", map(), "-o", path("b.ndf.exr")});
    return all;
  }

  void expect_done_or_refused(const std::string& limit, const std::vector<std::string>& command) const {
    std::string line = limit + ": ";
    for (const std::string& word : command) line += " " + fs::path(word).filename().string();
    SCOPED_TRACE(line);
    fs::remove_all(path("out"));
    fs::create_directory(path("out"));
    std::vector<std::string> shell = {"bash", "-c", "ulimit " + limit + "; exec \"$@\"", "bash"};
    shell.insert(shell.end(), command.begin(), command.end());
    const ProgramResult result = run_program(shell);
    EXPECT_EQ(result.signal, 0) << result.err;
    EXPECT_TRUE(result.exit_code == 0 || result.exit_code == kEnvironment) << result.exit_code << " " << result.err;
    for (const fs::directory_entry& left : fs::recursive_directory_iterator(path("out"))) {
      const std::string name = left.path().filename().string();
      EXPECT_FALSE(name.starts_with('.') && name != ".multum-export") << left.path();
    }
    if (result.exit_code == 0) return;
    EXPECT_NE(result.err, "");
    EXPECT_EQ(result.err.find("unexpected error"), std::string::npos) << result.err;
  }

  // By default, each command gets one of the limits.
  void sweep(const std::vector<std::string>& limits) const {
    std::size_t next = 0;
    for (const std::vector<std::string>& command : commands()) {
      if (!fs::exists(command.front())) continue;
      for (std::size_t i = 0; i < limits.size(); ++i)
        if (all_sweeps() || i == next) expect_done_or_refused(limits[i], command);
      next = (next + 1) % limits.size();
    }
  }
};

TEST_F(LimitSweepTest, SizesOfFiles) { sweep({"-f 1", "-f 4", "-f 40"}); }
TEST_F(LimitSweepTest, OpenFiles) { sweep({"-n 8", "-n 14", "-n 22"}); }
#ifndef MULTUM_SHADOW_MEMORY
TEST_F(LimitSweepTest, Memory) { sweep({"-v 250000", "-v 450000", "-v 700000"}); }

// OpenGL drivers terminate a program with a signal when memory runs out. The drivers' memory use differs between
// machines.
TEST_F(LimitSweepTest, MemoryOfDrivers) {
  if (!fs::exists(program("multum-view"))) GTEST_SKIP() << "without multum-view";
  for (int limit = 200000; limit < 480000; limit += all_sweeps() ? 12000 : 40000)
    expect_done_or_refused("-v " + std::to_string(limit),
                           {program("multum-view"), path("moments.ndf.exr"), "-o", out("a.png"), "--size", "32x32"});
}
#endif

}  // namespace
}  // namespace multum::testing
