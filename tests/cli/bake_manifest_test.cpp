// SPDX-License-Identifier: Apache-2.0
// Tests multum bake --manifest and its check in a build pipeline: which maps are unchanged, baked or failed, for what
// reasons, and what the reports say.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>

#include "host/formats/asset/header_hash.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/cli/program.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

// Makes two maps, which are baked to out/. The first map has colours.
class BakeManifestCommandTest : public CliTest {
 protected:
  void SetUp() override {
    fs::create_directory(path("out"));
    make_map("a", 32);
    make_map("b", 16);
    write_manifest("");
  }
  // `more` holds additional keys of map b.
  void write_manifest(const std::string& more) const {
    write_bytes(path("maps.toml"),
                "[defaults]\ngreen = \"up\"\n[[map]]\ninput = \"a_normal.png\"\nalbedo = \"a_albedo.png\"\n"
                "output = \"out/a.ndf.exr\"\n[[map]]\ninput = \"b_normal.png\"\noutput = \"out/b.ndf.exr\"\n" +
                    more);
  }
  ProgramResult bake(std::vector<std::string> options = {}) const {
    options.insert(options.begin(), {"bake", "--manifest", path("maps.toml")});
    return multum(options);
  }
  std::unique_ptr<TemporaryFolder> bake_once() const {
    const ProgramResult result = bake({"-q"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    auto folder = std::make_unique<TemporaryFolder>();
    for (const char* name : {"a.ndf.exr", "b.ndf.exr"}) fs::rename(path("out/") + name, *folder / name);
    return folder;
  }
  // Runs bake() on the maps and the manifest of SetUp(). All cases share this one bake.
  void bake_all() const {
    static const std::unique_ptr<TemporaryFolder> baked = bake_once();
    for (const char* name : {"a.ndf.exr", "b.ndf.exr"}) fs::copy_file(*baked / name, path("out/") + name);
  }
  // Returns the modification times of all files in the folder and in out/, except for the check's own reports.
  std::map<std::string, fs::file_time_type> times() const {
    std::map<std::string, fs::file_time_type> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      if (entry.is_regular_file()) found[entry.path().string()] = entry.last_write_time();
    return found;
  }
  // Damages the middle of the pixel data, which follow the header of the last part. Flips one bit in each of 64 bytes,
  // because a single bit could be in a part or tile header, where it might change no value that is read.
  void damage(const std::string& name) const {
    std::string bytes = read_bytes(path(name));
    const std::size_t header = bytes.rfind(std::string("chlist") + '\0');
    ASSERT_NE(header, std::string::npos);
    const std::size_t middle = header + (bytes.size() - header) / 2;
    for (std::size_t at = middle; at < middle + 64; ++at) bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_bytes(path(name), bytes);
  }
  // Replaces a source with other noise of the same size.
  void edit_source(const std::string& name, int size) const {
    const ProgramResult made = multum({"testmap", path(name), "--size", std::to_string(size), "--seed", "8"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  // Expects that the check reports `state` for map b with the reasons `why`, reports no problem for map a, and passes
  // after a repair.
  void expect_finding(const std::string& state, const std::vector<std::string>& why) const {
    const auto before = times();
    const ProgramResult dry = bake({"--check", "--dry-run"});
    EXPECT_EQ(dry.exit_code, 5) << dry.err;
    EXPECT_EQ(times(), before) << "a dry run wrote";
    const ProgramResult check = bake({"--check"});
    EXPECT_EQ(check.exit_code, 5) << check.err;
    for (const ProgramResult& result : {dry, check}) {
      EXPECT_TRUE(contains(result.err, fmt::format("1 {}\n  {:<8} out/b.ndf.exr: ", state, state))) << result.err;
      expect_says(result.err, {"FAILED", "1 of 2 maps"});
      expect_says(result.err, why);
    }
    EXPECT_FALSE(contains(dry.err, "baked now")) << dry.err;
    EXPECT_TRUE(contains(check.err, "; baked now")) << check.err;
    EXPECT_EQ(times().at(path("out/a.ndf.exr")), before.at(path("out/a.ndf.exr")));
    const ProgramResult again = bake({"--check"});
    EXPECT_EQ(again.exit_code, 0) << again.err;
  }
};

TEST_F(BakeManifestCommandTest, BakesAsTheCommandLineDoes) {
  write_manifest("lobes = 2\nwrap = \"clamp\"\ndata_format = \"half\"\nalign = 0.3\niterations = 9\n");
  const ProgramResult result = bake();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(contains(result.out, "out/a.ndf.exr: written")) << result.out;
  expect_says(result.out, {"multum bake: ", "passed", "2 maps", "2 baked\n"});
  const auto same = [&](const std::string& name, std::vector<std::string> options) {
    options.insert(options.begin(),
                   {"bake", path(name + "_normal.png"), "-o", path(name + ".ndf.exr"), "--green", "up"});
    const ProgramResult alone = multum(options);
    EXPECT_EQ(alone.exit_code, 0) << alone.err;
    EXPECT_TRUE(read_bytes(path(name + ".ndf.exr")) == read_bytes(path("out/" + name + ".ndf.exr"))) << name;
  };
  same("a", {"--albedo", path("a_albedo.png")});
  same("b", {"--lobes", "2", "--wrap", "clamp", "-d", "half", "--align", "0.3", "--iterations", "9"});
}

TEST_F(BakeManifestCommandTest, WhatIsUpToDateIsLeftAlone) {
  bake_all();
  const auto before = times();
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--check"}, {"--check", "--dry-run"}}) {
    const ProgramResult result = bake(options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    expect_says(result.out, {"passed", "2 maps", "2 unchanged\n"});
    EXPECT_TRUE(contains(result.out, options.empty() ? "out/b.ndf.exr: unchanged" : "out/b.ndf.exr: in place, "))
        << result.out;
  }
  EXPECT_EQ(times(), before);
  fs::last_write_time(path("b_normal.png"), fs::file_time_type::clock::now());
  EXPECT_EQ(bake({"--check"}).exit_code, 0) << "touched, but of the same bytes";
  EXPECT_EQ(times().at(path("out/b.ndf.exr")), before.at(path("out/b.ndf.exr")));
  const ProgramResult forced = bake({"--force"});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  expect_says(forced.out, {"2 maps", "2 baked"});
  EXPECT_NE(times().at(path("out/b.ndf.exr")), before.at(path("out/b.ndf.exr")));
}

TEST_F(BakeManifestCommandTest, AnEditedSourceIsStale) {
  bake_all();
  edit_source("b", 16);
  expect_finding("stale", {"source", "changed"});
  write_bytes(path("b_normal.png"), read_bytes(path("a_normal.png")));
  const ProgramResult plain = bake();
  EXPECT_EQ(plain.exit_code, 0) << plain.err;
  expect_says(plain.out, {"2 maps", "1 unchanged", "1 baked"});
  EXPECT_EQ(read_movmf_header(path("out/b.ndf.exr")).width(), 32);
}

TEST_F(BakeManifestCommandTest, OtherSettingsAreStale) {
  bake_all();
  write_manifest("lobes = 2\nkappa_cap = 250.5\n");
  expect_finding("stale", {"kappa_cap", "500", "250.5", "lobes", "4", "2"});
  fs::copy(path("b_normal.png"), path("grey.png"));
  write_manifest("lobes = 2\nkappa_cap = 250.5\nalbedo = \"grey.png\"\n");
  expect_finding("stale", {"albedo", "changed"});
}

TEST_F(BakeManifestCommandTest, AFileThatWasNotMeasuredIsStale) {
  bake_all();
  ASSERT_EQ(
      multum({"bake", path("b_normal.png"), "-o", path("out/b.ndf.exr"), "--green", "up", "--no-measure", "--force"})
          .exit_code,
      0);
  expect_finding("stale", {"error", "not measured"});
}

TEST_F(BakeManifestCommandTest, ADeletedFileIsMissing) {
  bake_all();
  fs::remove(path("out/b.ndf.exr"));
  expect_finding("missing", {"no such file"});
}

TEST_F(BakeManifestCommandTest, FlippedBitsAreDamage) {
  bake_all();
  const std::string whole = read_bytes(path("out/b.ndf.exr"));
  damage("out/b.ndf.exr");
  EXPECT_EQ(bake().exit_code, 0) << "without --check, the header's error counts";
  expect_finding("damaged", {});
  EXPECT_TRUE(read_bytes(path("out/b.ndf.exr")) == whole);
}

TEST_F(BakeManifestCommandTest, AWrongChecksumIsDamage) {
  bake_all();
  std::string bytes = read_bytes(path("out/b.ndf.exr"));
  const std::string hash = read_movmf_header(path("out/b.ndf.exr")).header.provenance.content_hash;
  for (std::size_t at = bytes.find(hash); at != std::string::npos; at = bytes.find(hash, at))
    bytes.replace(at, 4, "0000");
  write_bytes(path("out/b.ndf.exr"), bytes);
  expect_finding("damaged", {"checksum", hash});
}

TEST_F(BakeManifestCommandTest, WhatIsNoBakedFileIsDamage) {
  bake_all();
  write_bytes(path("out/b.ndf.exr"), "no baked file");
  expect_finding("damaged", {"baked file"});
}

// The stored checksum covers only the pixels, so only a measurement reveals that a header states too low an error. The
// test writes a false error and a matching header checksum, like a program that measures wrongly.
TEST_F(BakeManifestCommandTest, AFileIsHeldToWhatItStates) {
  bake_all();
  std::string bytes = read_bytes(path("out/b.ndf.exr"));
  const std::string hash = header_hash_text(path("out/b.ndf.exr"));
  const std::string stated = read_movmf_header(path("out/b.ndf.exr")).header.provenance.measured_error;
  const std::size_t row = stated.find("\"blinn-phong:500\",", stated.find("[1,\"centre\",\"blinn-phong:500\""));
  const std::size_t figure = row + std::string("\"blinn-phong:500\",").size();
  std::string forged = stated;
  for (std::size_t i = figure; forged[i] != ']'; ++i) forged[i] = forged[i] == '.' ? '.' : '0';
  ASSERT_NE(forged, stated);
  bytes.replace(bytes.find(stated), stated.size(), forged);
  write_bytes(path("out/b.ndf.exr"), bytes);
  const std::string forged_hash = header_hash_text(path("out/b.ndf.exr"));
  ASSERT_EQ(forged_hash.size(), hash.size());
  bytes.replace(bytes.find(hash), hash.size(), forged_hash);
  write_bytes(path("out/b.ndf.exr"), bytes);
  const auto before = times();
  const ProgramResult check = bake({"--check"});
  EXPECT_EQ(check.exit_code, 5) << check.err;
  EXPECT_TRUE(contains(check.err, "1 worse\n  worse    out/b.ndf.exr: ")) << check.err;
  expect_says(check.err, {"level 1", "centre", "blinn-phong:500", "0 %"});
  EXPECT_EQ(times(), before) << "a worse file is not baked again";
}

TEST_F(BakeManifestCommandTest, ErrorMaxIsHeld) {
  write_manifest("error_max = 0.01\n");
  const ProgramResult baked = bake();
  EXPECT_EQ(baked.exit_code, 5) << baked.err;
  EXPECT_TRUE(contains(baked.out, "out/b.ndf.exr: written")) << "the worse file stays for inspection\n" << baked.out;
  const auto before = times();
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--check"}}) {
    const ProgramResult result = bake(options);
    EXPECT_EQ(result.exit_code, 5) << result.err;
    expect_says(result.err, {"FAILED", "1 of 2 maps", "1 worse\n  worse    out/b.ndf.exr: ", "error_max", "1 %\n"});
  }
  EXPECT_EQ(times(), before);
  write_manifest("error_max = 0.99\n");
  EXPECT_EQ(bake({"--check"}).exit_code, 0) << "the allowed error is not a setting of the file";
  EXPECT_EQ(times().at(path("out/b.ndf.exr")), before.at(path("out/b.ndf.exr")));
}

TEST_F(BakeManifestCommandTest, OneBadMapDoesNotStopTheOthers) {
  write_bytes(path("broken.png"), "no picture");
  write_bytes(
      path("maps.toml"),
      "[[map]]\ninput = \"broken.png\"\noutput = \"out/c.ndf.exr\"\n[[map]]\ninput = \"none_<UDIM>.png\"\n"
      "output = \"out/<UDIM>.exr\"\n[[map]]\ninput = \"a_normal.png\"\ngreen = \"up\"\noutput = \"out/a.ndf.exr\"\n");
  for (const bool is_check : {false, true}) {
    const ProgramResult result = is_check ? bake({"--check"}) : bake();
    expect_refusal(result, kInput,
                   {"FAILED", "2 of 3 maps", "2 failed\n", "\n  failed   out/c.ndf.exr: ", "broken.png",
                    "\n  failed   out/<UDIM>.exr: ", "none_<UDIM>.png"});
    EXPECT_TRUE(fs::exists(path("out/a.ndf.exr")));
    EXPECT_FALSE(fs::exists(path("out/c.ndf.exr")));
  }
  fs::remove(path("out/a.ndf.exr"));
  EXPECT_EQ(bake({"--check", "--dry-run"}).exit_code, 3) << "an unreadable source is reported before a missing file";
}

// A map that a bake would refuse counts as failed and not as missing. The reason is given, whether or not the bake is
// tried. A report lists such a map as an error, and a map that a bake would repair as a failure.
TEST_F(BakeManifestCommandTest, WhatCannotBeBakedSaysWhyItIsMissing) {
  bake_all();
  fs::remove(path("out/a.ndf.exr"));
  fs::copy_file(path("b_normal.png"), path("small.png"));
  struct Refused {
    std::string keys;  // keys of a map that reads a_normal.png and has no output yet
    std::vector<std::string> why;
  };
  for (const Refused& c : {Refused{"albedo = \"small.png\"\n", {"small.png", "16 x 16", "32 x 32"}},
                           Refused{"roughness = \"small.png\"\n", {"small.png", "16 x 16", "32 x 32"}},
                           Refused{"first_level = 9\n", {"9"}}}) {
    SCOPED_TRACE(c.keys);
    write_bytes(path("maps.toml"),
                "[[map]]\ninput = \"a_normal.png\"\ngreen = \"up\"\noutput = \"out/c.ndf.exr\"\n" + c.keys +
                    "[[map]]\ninput = \"a_normal.png\"\ngreen = \"up\"\noutput = \"out/a.ndf.exr\"\n");
    const auto before = times();
    const ProgramResult dry = bake({"--check", "--dry-run", "--junit", path("junit.xml")});
    std::map<std::string, fs::file_time_type> after = times();
    after.erase(path("junit.xml"));
    EXPECT_EQ(after, before);
    expect_refusal(dry, kInput,
                   {"1 missing, 1 failed\n",
                    "failed   out/c.ndf.exr: there is no such file, and cannot be "
                    "baked: "});
    expect_says(dry.err, c.why);
    const std::string junit = read_bytes(path("junit.xml"));
    expect_says(junit, {"failures=\"1\" errors=\"1\"", "<error type=\"failed\"", "<failure type=\"missing\""});
    fs::remove(path("junit.xml"));
    expect_refusal(bake({"--check"}), kInput, {"failed   out/c.ndf.exr: there is no such file, and cannot be baked: "});
    EXPECT_FALSE(fs::exists(path("out/c.ndf.exr")));
    fs::remove(path("out/a.ndf.exr"));
  }
}

// A bake creates output folders. A dry run does not create any and reports the file as missing. If a map fails, its
// report entry still has the size of the existing file.
TEST_F(BakeManifestCommandTest, MakesTheFoldersOfItsOutputs) {
  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"b_normal.png\"\ngreen = \"up\"\noutput = \"new/deep/b.ndf.exr\"\n");
  const ProgramResult dry = bake({"--check", "--dry-run"});
  expect_refusal(dry, kVerification, {"1 missing\n  missing  new/deep/b.ndf.exr: there is no such file\n"});
  EXPECT_FALSE(fs::exists(path("new")));
  EXPECT_EQ(bake().exit_code, 0);
  const auto bytes = fs::file_size(path("new/deep/b.ndf.exr"));
  write_bytes(path("b_normal.png"), "no picture");
  EXPECT_EQ(bake({"--check", "--dry-run", "--summary", path("summary.md")}).exit_code, kInput);
  expect_says(read_bytes(path("summary.md")), {fmt::format(" | {} |\n", bytes)});
  fs::remove(path("new/deep/b.ndf.exr"));
  EXPECT_EQ(bake({"--check", "--dry-run", "--summary", path("summary.md")}).exit_code, kInput);
  expect_says(read_bytes(path("summary.md")), {" | - |\n"});
}

// The report treats a target as an assertion about the map, so a missed target is a failure and not an error.
TEST_F(BakeManifestCommandTest, AMissedTargetIsAFailureOfTheReport) {
  write_manifest("target_error = 0.00001\nndf = \"moments\"\n");
  EXPECT_EQ(bake({"--junit", path("junit.xml")}).exit_code, 5);
  expect_says(read_bytes(path("junit.xml")), {"failures=\"1\" errors=\"0\"", "<failure type=\"worse\""});
}

TEST_F(BakeManifestCommandTest, SetsAreBakedTileByTile) {
  for (const char* tile : {"1001", "1002"}) fs::copy(path("a_normal.png"), path(std::string("rock_") + tile + ".png"));
  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"rock_<UDIM>.png\"\noutput = \"out/rock_<UDIM>.ndf.exr\"\ngreen = \"up\"\n");
  EXPECT_EQ(bake().exit_code, 0);
  EXPECT_TRUE(fs::exists(path("out/rock_1001.ndf.exr")));
  fs::remove(path("out/rock_1002.ndf.exr"));
  const ProgramResult check = bake({"--check"});
  expect_refusal(check, kVerification, {"1 of 2 maps", "1 missing\n  missing  out/rock_1002.ndf.exr: "});
  EXPECT_EQ(bake({"--check"}).exit_code, 0);
}

TEST_F(BakeManifestCommandTest, ReportsAreWrittenWhenTheCheckFails) {
  bake_all();
  fs::rename(path("a_normal.png"), path("a <&>'.png"));
  write_bytes(path("maps.toml"),
              "[[map]]\ninput = \"a <&>'.png\"\noutput = \"out/ä <&>'|.ndf.exr\"\ngreen = \"up\"\n"
              "[[map]]\ninput = \"b_normal.png\"\noutput = \"out/b.ndf.exr\"\ngreen = \"up\"\nerror_max = 0.9\n"
              "[[map]]\ninput = \"none.png\"\noutput = \"out/none.ndf.exr\"\n");
  const ProgramResult check = bake({"--check", "--junit", path("junit.xml"), "--summary", path("summary.md")});
  EXPECT_EQ(check.exit_code, 3) << check.err;
  const ProgramResult parsed = run_program(
      {"python3", "-c",
       "import sys, xml.etree.ElementTree as tree\n"
       "root = tree.parse(sys.argv[1]).getroot()\n"
       "print(root.tag, root.get('tests'), root.get('failures'), root.get('errors'), float(root.get('time')) > 0)\n"
       "for case in root.iter('testcase'):\n"
       "  values = {p.get('name'): p.get('value') for p in case.iter('property')}\n"
       "  found = [(e.tag, e.get('type')) for e in case if e.tag != 'properties']\n"
       "  stated, measured = (float(values.get(k, -1)) for k in ('error_stated', 'error_measured'))\n"
       "  print(ascii(case.get('name')), float(case.get('time')) >= 0, values['state'], found,\n"
       "        abs(stated - measured) < 1e-5 and measured > 0, values.get('error_max'), int(values['bytes']) > 0)\n",
       path("junit.xml")});
  EXPECT_EQ(parsed.exit_code, 0) << parsed.err;
  EXPECT_EQ(parsed.out,
            "testsuites 3 1 1 True\n"
            "\"out/\\xe4 <&>'|.ndf.exr\" True missing [('failure', 'missing')] False None True\n"
            "'out/b.ndf.exr' True unchanged [] True 0.9 True\n"
            "'out/none.ndf.exr' True failed [('error', 'failed')] False None False\n");
  const std::string summary = read_bytes(path("summary.md"));
  EXPECT_EQ(summary.rfind("**multum bake --check: FAILED for 2 of 3 maps: 1 missing, 1 failed**\n", 0), 0u) << summary;
  EXPECT_TRUE(contains(summary, "| out/ä \\<\\&\\>'\\|.ndf.exr | missing |")) << summary;
  EXPECT_TRUE(contains(summary, "\n| out/b.ndf.exr | unchanged |")) << summary;
}

TEST_F(BakeManifestCommandTest, TheSummaryHasStdoutToItself) {
  const ProgramResult result = bake({"--summary", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("**multum bake: passed, 2 maps in place: 2 baked**\n\n| map | state |", 0), 0u)
      << result.out;
  EXPECT_FALSE(contains(result.out, "written")) << result.out;
  EXPECT_TRUE(contains(result.err, "out/a.ndf.exr: written")) << result.err;
}

TEST_F(BakeManifestCommandTest, ChoosesSettingsForATarget) {
  write_manifest("target_error = 0.5\nndf = \"vmf\"\n");
  const ProgramResult first = bake({"-q"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const auto before = times();
  const ProgramResult again = bake({"--check"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(times(), before);
  write_manifest("target_error = 0.4\nndf = \"vmf\"\n");
  const ProgramResult other = bake({"--check", "--dry-run"});
  expect_refusal(other, kVerification,
                 {"out/b.ndf.exr: ", "settings", "error of 0.5 for blinn-phong:100 by vmf",
                  "expected an error of 0.4 for blinn-phong:100 by vmf"});
  write_manifest("target_error = 0.00001\nndf = \"moments\"\n");
  const ProgramResult missed = bake();
  expect_refusal(missed, kVerification, {"no settings", "1e-05", "blinn-phong:100", "moments", "best", "not written"});
}

TEST_F(BakeManifestCommandTest, WhatDoesNotGoTogether) {
  const auto before = times();
  const auto refused = [&](const std::vector<std::string>& options, const std::vector<std::string>& parts,
                           int code = kUsage) { expect_refusal(bake(options), code, parts); };
  refused({path("a_normal.png")}, {"input", "--manifest"});
  refused({"-o", path("c.exr")}, {"--output", "--manifest"});
  refused({"--report", path("r.json")}, {"--report", "--manifest"});
  refused({"--no-measure"}, {"--no-measure", "--manifest"});
  refused({"--first-level", "1"}, {"--first-level", "--manifest", "first_level", "[[map]]"});
  refused({"-d", "half"}, {"--data-format", "--manifest", "data_format"});
  refused({"--bumpformat", "normal"}, {"--bumpformat", "--manifest"});
  refused({"--target-error", "0.1"}, {"--target-error", "--manifest", "target_error"});
  refused({"--check", "--force"}, {"--force", "excludes", "--check"});
  refused({"--dry-run"}, {"--dry-run", "requires", "--check"});
  for (const char* option : {"--junit", "--summary"}) {
    refused({option, path("a_normal.png")}, {"a_normal.png", "twice"});
    refused({option, path("out/b.ndf.exr")}, {"b.ndf.exr", "twice"});
    refused({option, path("maps.toml")}, {"maps.toml", "twice"});
    refused({option, "/proc/none/report"}, {"none", "folder"}, kEnvironment);
  }
  refused({"--junit", path("r"), "--summary", path("r")}, {path("r"), "twice"});
  for (const char* option : {"--check", "--junit", "--summary"}) {
    std::vector<std::string> command = {"bake", path("a_normal.png"), "-o", path("c.exr"), option};
    if (option != std::string("--check")) command.push_back(path("r"));
    expect_refusal(multum(command), kUsage, {option, "requires", "--manifest"});
  }
  write_manifest("lobes = 9\n");
  refused({"--check"}, {"maps.toml:10: ", "map.lobes", "9", "1 to 8"}, kInput);
  write_manifest("");
  EXPECT_EQ(times().size(), before.size()) << "nothing was written";
}

}  // namespace
}  // namespace multum::testing
