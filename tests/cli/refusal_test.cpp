// SPDX-License-Identifier: Apache-2.0
// Tests everything that multum refuses. The exit code and the message say why, and no file is left behind or
// overwritten.
#include <sys/resource.h>

#include <limits>
#include <random>

#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tools/command_line/absent_commands.h"

namespace multum::testing {
namespace {

class RefusalTest : public CliTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(path("out"));
    make_map("map", 64);
  }

  // Bakes `input` with `options`, once into an empty folder and once over an older file. Both bakes must be refused in
  // the same way: with `code`, and with `parts` on stderr.
  void expect_refused(const std::string& input, const std::vector<std::string>& options, int code,
                      const std::vector<std::string>& parts) {
    const std::string output = path("out/map.ndf.exr"), older = "an older file";
    std::vector<std::string> arguments = {"bake", input, "-o", output, "--report", path("out/report.json")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    for (const bool over_older : {false, true}) {
      std::set<std::string> expected;
      if (over_older) {
        for (const char* name : {"map.ndf.exr", "report.json"}) {
          write_bytes(path("out/") + name, older);
          expected.insert(name);
        }
      }
      expect_failure(multum(arguments), code, parts);
      EXPECT_EQ(out_names(), expected) << parts[0];
      for (const std::string& name : expected) {
        EXPECT_EQ(read_bytes(path("out/" + name)), older);
        std::filesystem::remove(path("out/" + name));
      }
    }
  }

  static void expect_failure(const ProgramResult& result, int code, const std::vector<std::string>& parts) {
    expect_refusal(result, code, parts);
    EXPECT_EQ(result.out.find("written"), std::string::npos) << result.out;
  }

  std::set<std::string> out_names() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path("out")))
      names.insert(entry.path().filename().string());
    return names;
  }
};

TEST_F(RefusalTest, InputsThatAreNoNormalMap) {
  expect_refused(path("missing.png"), {}, kInput, {"missing.png", "no such"});
  expect_refused(path("out"), {}, kInput, {path("out"), "is a folder"});
  expect_refused(path("map_albedo.png"), {}, kInput, {"map_albedo.png", "normal map", "height field", "unit vectors"});

  TestImage mask{.width = 64, .height = 64};  // areas of uniform red, green, blue and black
  for (int i = 0; i < 64 * 64; ++i)
    for (int c = 0; c < 3; ++c) mask.values.push_back((i / 8 + i / 512) % 4 == c ? 1.0f : 0.0f);
  write_test_image(path("mask.png"), mask);
  expect_refused(path("mask.png"), {}, kInput, {"mask.png", "normal map", "unit vectors"});

  TestImage grey{.width = 64, .height = 64, .channels = 1};
  for (int i = 0; i < 64 * 64; ++i) grey.values.push_back(i / 8 % 2 == 0 ? 0.0f : 1.0f);
  write_test_image(path("grey.png"), grey);
  expect_refused(path("grey.png"), {}, kInput, {"grey.png", "0 or 1", "mask", "--bumpformat height"});
  expect_refused(path("grey.png"), {"--two-channel"}, kInput, {"grey.png", "1 colour channel", "red and green"});

  write_bytes(path("text.png"), "not an image");
  expect_refused(path("text.png"), {}, kInput, {"text.png", "format", "PNG"});
  write_bytes(path("empty.png"), "");
  expect_refused(path("empty.png"), {}, kInput, {"empty.png", "format"});
}

TEST_F(RefusalTest, DamagedInputs) {
  const std::string whole = read_bytes(path("map_normal.png"));
  write_bytes(path("cut.png"), whole.substr(0, whole.size() / 2));
  expect_refused(path("cut.png"), {}, kInput, {"cut.png", "cut short: ", std::to_string(whole.size() / 2), "expected"});
  std::string damaged = whole;
  for (std::size_t i = damaged.size() / 2; i < damaged.size() / 2 + 64; ++i) damaged[i] = '\x55';
  write_bytes(path("damaged.png"), damaged);
  expect_refused(path("damaged.png"), {}, kInput, {"damaged.png", "damaged"});
}

TEST_F(RefusalTest, TooManyRepairsAndTooManyTexels) {
  TestImage map = normal_image(64, 64, true);
  map.type = OIIO::TypeDesc::FLOAT;
  for (int i = 0; i < 64; ++i) map.at(i, 7, 1) = std::numeric_limits<float>::quiet_NaN();  // 1.6 % of all texels
  write_test_image(path("nan.exr"), map);
  expect_refused(path("nan.exr"), {}, kInput, {"nan.exr", "64 ", "at most", "--repair-max"});
  expect_refused(path("nan.exr"), {"--checknan"}, kInput, {"nan.exr", "column 0, row 7", "finite"});
  expect_refused(path("nan.exr"), {"--fixnan", "none"}, kInput, {"nan.exr"});
  const ProgramResult repaired =
      multum({"bake", path("nan.exr"), "-o", path("out/nan.ndf.exr"), "--repair-max", "0.1", "--no-measure"});
  EXPECT_EQ(repaired.exit_code, 0) << repaired.err;
  std::filesystem::remove(path("out/nan.ndf.exr"));

  TestImage strip{.width = 40000, .height = 1};
  for (int i = 0; i < 40000; ++i) strip.values.insert(strip.values.end(), {0.5f, 0.5f, 1.0f});
  write_test_image(path("strip.png"), strip);
  expect_refused(path("strip.png"), {}, kInput, {"40000 x 1", "32768", "strip.png"});
}

TEST_F(RefusalTest, AlbedoOfAnotherSize) {
  make_map("small", 16);
  expect_refused(path("map_normal.png"), {"--albedo", path("small_albedo.png")}, kInput,
                 {"small_albedo.png", "16 x 16", "64 x 64"});
  expect_refused(path("map_normal.png"), {"--albedo", path("no_albedo.png")}, kInput, {"no_albedo.png", "No such"});
}

TEST_F(RefusalTest, SettingsOutsideTheirRanges) {
  const std::string map = path("map_normal.png");
  expect_refused(map, {"--lobes", "0"}, kUsage, {"--lobes", "0", "1 to 8"});
  expect_refused(map, {"--lobes", "9"}, kUsage, {"--lobes", "9", "1 to 8"});
  expect_refused(map, {"--iterations", "0"}, kUsage, {"--iterations", "0", "1 to 1000"});
  expect_refused(map, {"--first-level", "-1"}, kUsage, {"--first-level", "-1", "0 to 15"});
  expect_refused(map, {"--first-level", "7"}, kUsage, {"--first-level", "7", "0 to 6", "64 x 64"});
  expect_refused(map, {"--height-scale", "0"}, kUsage, {"--height-scale", "0", "other than 0"});
  expect_refused(map, {"--lobes", "four"}, kUsage, {"--lobes", "four"});
  expect_refused(map, {"--compression", "dwaa"}, kUsage, {"\"dwaa\"", "rle", "zips", "zip", "piz"});
  expect_refused(map, {"--compression", "zip:10"}, kUsage, {"\"zip:10\""});
  expect_refused(map, {"--data-format", "1"}, kUsage, {"--data-format", "\"1\"", "snorm16, half, float"});
  expect_refused(map, {"--order", "0"}, kUsage, {"--order", "\"0\"", "colour, scanline"});
  expect_refused(map, {"--fixnan", "2"}, kUsage, {"--fixnan", "\"2\"", "none, black, box3"});
  expect_refused(map, {"--bumpformat", "bump"}, kUsage, {"--bumpformat", "\"bump\"", "auto, height, normal"});
  expect_refused(map, {"--wrap", "repeat"}, kUsage, {"--wrap", "repeat"});
  expect_refused(map, {"--threads", "0"}, kUsage, {"--threads", "0"});
  expect_refused(map, {"--signed", "--unsigned"}, kUsage, {"--signed", "--unsigned"});
  expect_refused(map, {"--device", "no such device"}, kEnvironment, {"'no such device'", "number", "name"});
}

TEST_F(RefusalTest, OutputsThatCannotBe) {
  const std::string map = path("map_normal.png");
  const auto bake = [&](const std::string& output) { return multum({"bake", map, "-o", output}); };
  expect_failure(bake("/proc/none/map.ndf.exr"), kEnvironment, {"/proc/none", "folder"});
  expect_failure(bake(path("out")), kUsage, {path("out"), "expected"});
  expect_failure(bake(path("out/map.png")), kUsage, {"out/map.png", ".ndf.exr"});
  std::filesystem::create_directory(path("out/folder.exr"));
  expect_failure(bake(path("out/folder.exr")), kUsage, {"folder.exr", "a folder"});
  std::filesystem::remove(path("out/folder.exr"));
  // Nobody can write into this folder, not even root.
  expect_failure(bake("/proc/map.ndf.exr"), kEnvironment, {"/proc/map.ndf.exr", "cannot create"});
  expect_failure(multum({"bake", map, "-o", path("out/map.exr"), "--report", "/proc/none/r.json"}), kEnvironment,
                 {"/proc/none", "folder"});
  expect_failure(multum({"bake", map, "-o", path("map_albedo.exr"), "--albedo", path("map_albedo.exr")}), kUsage,
                 {"map_albedo.exr", "twice"});
  EXPECT_EQ(out_names(), std::set<std::string>());
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"map_normal.png", "map_albedo.png", "out"}));
}

TEST_F(RefusalTest, AFullDiskLeavesTheOlderFile) {
  const std::string output = path("out/map.ndf.exr");
  std::vector<std::string> command = multum_command({"bake", path("map_normal.png"), "-o", output, "--quiet"});
  ASSERT_EQ(run_program(command).exit_code, 0);  // builds the kernels first, because compilers write files too
  write_bytes(output, "an older file");
  // A limit on file sizes simulates a full disk, because write() fails in the middle of the file.
  command.insert(command.begin(), {"bash", "-c", "trap '' XFSZ; ulimit -f 64; exec \"$@\"", "bash"});
  expect_failure(run_program(command), kEnvironment, {"map.ndf.exr", "writing"});
  EXPECT_EQ(out_names(), std::set<std::string>{"map.ndf.exr"});
  EXPECT_EQ(read_bytes(output), "an older file");
  EXPECT_EQ(multum({"bake", path("map_normal.png"), "-o", output, "--quiet"}).exit_code, 0);
}

TEST_F(RefusalTest, ResultsThatNobodyCanRead) {
  const std::string output = path("out/map.ndf.exr");
  std::vector<std::string> command = multum_command({"bake", path("map_normal.png"), "-o", output, "--no-measure"});
  command.insert(command.begin(), {"bash", "-c", "exec \"$@\" > /dev/full", "bash"});
  expect_failure(run_program(command), kEnvironment, {"standard output", "written"});
}

TEST_F(RefusalTest, DamagedBakedFiles) {
  const std::string baked = path("out/map.ndf.exr"), bad = path("out/bad.ndf.exr");
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", baked, "--compression", "none", "--quiet", "--no-measure"})
                .exit_code,
            0);
  const std::string whole = read_bytes(baked);

  std::string flipped = whole;
  flipped[whole.size() * 3 / 4] = static_cast<char>(flipped[whole.size() * 3 / 4] ^ 0x10);
  write_bytes(bad, flipped);
  const ProgramResult verify = multum({"verify", bad});
  expect_failure(verify, kVerification, {"bad.ndf.exr", "verification"});
  EXPECT_NE(verify.out.find("FAILED checksum   found "), std::string::npos) << verify.out;

  // kappaMax is 20000; the value follows its name, type and size.
  std::string less_sharp = whole;
  const std::string name("multum:kappaMax\0float\0\4\0\0\0", 26);
  const std::size_t kappa_at = whole.find(name);
  ASSERT_NE(kappa_at, std::string::npos);
  less_sharp.replace(kappa_at + name.size(), 4, std::string("\0\0\x48\x43", 4));  // 200
  write_bytes(bad, less_sharp);
  const ProgramResult header = multum({"verify", bad});
  expect_failure(header, kVerification, {"bad.ndf.exr", "verification"});
  EXPECT_NE(header.out.find("FAILED header"), std::string::npos) << header.out;
  EXPECT_NE(header.out.find("multum:kappaMax;"), std::string::npos) << header.out;

  for (const std::size_t size : {whole.size() - 1, whole.size() / 2, std::size_t{3000}, std::size_t{100}}) {
    write_bytes(bad, whole.substr(0, size));
    expect_failure(multum({"verify", bad}), kInput, {"bad.ndf.exr", "baked file"});
  }
  for (const char* command : {"verify", "info"}) {
    write_bytes(bad, whole.substr(0, 3000));
    expect_failure(multum({command, bad}), kInput, {"bad.ndf.exr", "baked file"});
    write_bytes(bad, "");
    expect_failure(multum({command, bad}), kInput, {"bad.ndf.exr", "baked file"});
    expect_failure(multum({command, path("none.exr")}), kInput, {"none.exr", "No such"});
    expect_failure(multum({command, path("out")}), kInput, {path("out")});
    write_test_image(path("foreign.exr"), normal_image(8, 8));
    expect_failure(multum({command, path("foreign.exr")}), kInput,
                   {"foreign.exr", "multum:representation", "written by"});
    expect_failure(multum({command, path("map_normal.png")}), kInput, {"map_normal.png", "baked file"});
  }
}

TEST_F(RefusalTest, ABakedFileWithAnyByteFlippedNeverCrashesVerify) {
  const std::string baked = path("out/map.ndf.exr"), bad = path("out/bad.ndf.exr");
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", baked, "--quiet", "--no-measure"}).exit_code, 0);
  const std::string whole = read_bytes(baked);
  const unsigned seed = 5;
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (int i = 0; i < 30; ++i) {
    // Half of the changed bytes are in the headers, although these are a small part of the file.
    const std::size_t at = random() % (i % 2 == 0 ? 12000 : whole.size());
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << random() % 8));
    write_bytes(bad, flipped);
    const ProgramResult result = multum({"verify", bad});
    EXPECT_EQ(result.signal, 0) << "byte " << at;
    if (result.exit_code != 0) {
      EXPECT_NE(result.err.find("bad.ndf.exr"), std::string::npos) << "byte " << at << ": " << result.err;
    }
  }
}

// A key of 32,000 parts has 64 KB. The parser once used a stack frame for each part, and a signal terminated the
// program.
TEST_F(RefusalTest, TomlFilesBeyondTheLimits) {
  std::string key = "a";
  for (int i = 1; i < 32'000; ++i) key += ".a";
  const std::string file = path("deep.toml");
  write_bytes(file, "# one line\n" + key + " = 1\n");
  std::vector<std::vector<std::string>> commands = {
      {"plan", file},
      {"bake", "--manifest", file},
      {"infer", file, "-o", path("out/inferred")},
  };
  if (has_command("serve")) commands.push_back({"serve", "--data", path("out/data"), "--config", file});
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command[0]);
    expect_refusal(multum_program(command), kInput, {file + ":2:", "dotted key", "32", "expected"});
    EXPECT_EQ(out_names(), std::set<std::string>());
  }
}

TEST_F(RefusalTest, WrongCommandLines) {
  expect_failure(multum({}), kUsage,
                 {"no command",
                  "bake plan tradeoff info verify materials testmap mip reflectance lod export gltf check look shaders "
                  "animation infer "
                  "pack unpack player",
                  "--help"});
  expect_failure(multum({"cook"}), kUsage, {"unknown command 'cook'", ": bake"});
  expect_failure(multum({"bake"}), kUsage, {"input", "required", "multum bake --help"});
  expect_failure(multum({"bake", path("map_normal.png")}), kUsage, {"--output", "required", "multum bake --help"});
  expect_failure(multum({"bake", path("map_normal.png"), "-o", path("out/a.exr"), "--cheap"}), kUsage,
                 {"--cheap", "multum bake --help"});
  expect_failure(multum({"bake", path("map_normal.png"), "-o", path("out/a.exr"), "--lobs", "3"}), kUsage,
                 {"unknown option '--lobs'", "'--lobes'", "multum bake --help"});
  expect_failure(multum({"bake", path("map_normal.png"), "-o"}), kUsage, {"--output"});
  expect_failure(multum({"info"}), kUsage, {"file", "required", "multum info --help"});
  expect_failure(multum({"verify"}), kUsage, {"file", "required", "multum verify --help"});
  expect_failure(multum({"testmap"}), kUsage,
                 {"required", "Usage: multum testmap", "multum testmap out/test", "multum testmap --help"});
  expect_failure(multum({"testmap", path("t"), "--size", "17"}), kUsage, {"--size", "17", "even"});
  expect_failure(multum({"testmap", path("t"), "--size", "8"}), kUsage, {"--size", "32768"});
  EXPECT_EQ(out_names(), std::set<std::string>());
}

TEST_F(RefusalTest, CommandsThatABuildLacks) {
  CLI::App app("", "multum");
  add_absent_commands(app, {"serve"}, "farm", "MULTUM_FARM");
  EXPECT_EQ(app.help().find("serve"), std::string::npos);
  for (const std::string words : {"serve", "serve --data x --config y", "serve --help"}) {
    try {
      app.parse(words);
      FAIL() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      EXPECT_EQ(std::string(error.what()),
                "serve: this build of multum has no farm; expected a build with the CMake option -DMULTUM_FARM=ON, as "
                "made by tools/demo --all");
    }
  }
  for (const char* name : {"openjd", "serve", "jobs"}) {
    if (has_command(name)) continue;
    expect_failure(multum({name, "x", "--json"}), kUsage, {name, "no farm", "-DMULTUM_FARM=ON"});
  }
}

}  // namespace
}  // namespace multum::testing
