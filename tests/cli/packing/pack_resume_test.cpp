// SPDX-License-Identifier: Apache-2.0
// Tests multum pack within a memory limit and after a stop. The command gives the same bytes, whichever inputs it reads
// again and whichever results it reuses.
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "host/fields/codec/packing/field_coder.h"
#include "host/fields/codec/packing/field_packing.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/progress.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class PackResumeTest : public TracedSceneTest {
 protected:
  void SetUp() override { infer_scene({}); }

  FieldPackSettings settings(const std::string& file) const {
    FieldPackSettings settings;
    settings.folder = path("out");
    settings.output = path(file);
    settings.target.bytes = 6000;
    return settings;
  }
  std::string packed_bytes(const FieldPackSettings& how) const {
    pack_field(how, nullptr);
    return read_bytes(how.output);
  }
  std::string partial(const std::string& file) const { return path(".multum-partial-" + file); }
  /// Stops a packing after it has coded this many chunks.
  void stop_after(std::uint64_t chunks, const FieldPackSettings& how) const {
    std::uint64_t most = 0;
    Progress progress([&](const ProgressEvent& event) {
      most = std::max(most, event.units_total > 0 ? event.units_done : 0);
      return most < chunks;
    });
    EXPECT_THROW(pack_field(how, &progress), Cancelled);
    EXPECT_FALSE(fs::exists(how.output));
  }
};

TEST_F(PackResumeTest, LittleMemoryGivesTheSameBytes) {
  const FieldSource source =
      read_field_source({path("out"), path("field.mpt"), false, 8, false, image_coders({}), 2}, nullptr);
  const std::vector<std::uint8_t> description = encode_description(source.description);
  FieldCoderSettings coding;
  coding.threads = 2;
  std::uint64_t textures = 0, most = 0;
  for (const ChunkToCode& chunk : source.chunks) {
    textures += chunk.texture_bytes();
    most = std::max(most, chunk.texture_bytes() + FieldCoder::bytes_of(chunk, false));
  }
  ASSERT_GT(source.chunks.size(), 1u);
  coding.memory_bytes = 100 * (textures + most);
  FieldCoder much(source, description, coding, nullptr);
  coding.memory_bytes = most;
  FieldCoder little(source, description, coding, nullptr);
  for (const double lambda : {50.0, 60.0}) EXPECT_EQ(much.code(lambda).file, little.code(lambda).file) << lambda;
  coding.memory_bytes = most - 1;
  EXPECT_THROW(FieldCoder(source, description, coding, nullptr), Error);
  const ProgramResult refused = multum({"pack", path("out"), "-o", path("field.mpt"), "--memory", "10M"});
  expect_refusal(refused, kUsage, {"--memory"});
}

TEST_F(PackResumeTest, WhatWasCodedIsTakenUp) {
  const std::string whole = packed_bytes(settings("whole.mpt"));
  EXPECT_FALSE(fs::exists(partial("whole.mpt")));
  FieldPackSettings how = settings("field.mpt");
  stop_after(5, how);
  EXPECT_FALSE(fs::exists(partial("field.mpt"))) << "without resume no partial work is kept";
  how.resume = true;
  stop_after(5, how);
  ASSERT_TRUE(fs::exists(partial("field.mpt") + "/chunks"));
  stop_after(8, how);  // this number includes the five earlier chunks
  const FieldPackReport report = pack_field(how, nullptr);
  EXPECT_GE(report.chunks_resumed, 7u);
  EXPECT_EQ(read_bytes(how.output), whole);
  EXPECT_FALSE(fs::exists(partial("field.mpt")));
}

TEST_F(PackResumeTest, WhatIsDamagedOrOfOtherSettingsIsCodedAgain) {
  const std::string whole = packed_bytes(settings("whole.mpt"));
  FieldPackSettings how = settings("field.mpt");
  how.resume = true;
  const std::string chunks = partial("field.mpt") + "/chunks";
  for (const bool is_cut : {true, false}) {
    stop_after(6, how);
    std::string bytes = read_bytes(chunks);
    if (is_cut) bytes.resize(bytes.size() - 3);
    else bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    write_bytes(chunks, bytes);
    const FieldPackReport report = pack_field(how, nullptr);
    EXPECT_GT(report.chunks_resumed, 0u);
    EXPECT_LT(report.chunks_resumed, 6u);
    EXPECT_EQ(read_bytes(how.output), whole);
    fs::remove(how.output);
  }
  stop_after(6, how);
  how.coder = ImageCoder::kWavelet;
  EXPECT_EQ(pack_field(how, nullptr).chunks_resumed, 0u);
  FieldPackSettings alone = settings("alone.mpt");
  alone.coder = ImageCoder::kWavelet;
  EXPECT_EQ(read_bytes(how.output), packed_bytes(alone));
}

TEST_F(PackResumeTest, AKilledPackingGoesOn) {
  const std::vector<std::string> arguments = {"pack",      path("out"), "-o",      path("field.mpt"), "--resume",
                                              "--mse-max", "0.002",     "--quiet", "--pyramid",       "greedy"};
  Program packing(multum_command(arguments));
  const auto coded = [&] {
    std::error_code none;
    const auto size = fs::file_size(partial("field.mpt") + "/chunks", none);
    return none ? 0 : size;
  };
  while (packing.running() && coded() < 1000) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  packing.send(SIGKILL);
  ASSERT_EQ(packing.wait().signal, SIGKILL) << "packing ended before the kill";
  EXPECT_FALSE(fs::exists(path("field.mpt")));
  ProgramResult result = multum(
      {"pack", path("out"), "-o", path("field.mpt"), "--resume", "--mse-max", "0.002", "-v", "--pyramid", "greedy"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  expect_says(result.out, {"reused from an interrupted run"});
  EXPECT_EQ(multum({"verify", path("field.mpt")}).exit_code, 0);
}

}  // namespace
}  // namespace multum::testing
