// SPDX-License-Identifier: Apache-2.0
// Tests multum pack, unpack, info and verify on a small inferred animation: unpacked textures, targets, and the effect
// of damage. Also tests that the bytes do not depend on the number of threads.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packing/field_packing.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/foundation/base/error.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class PackCommandTest : public TracedSceneTest {
 protected:
  void SetUp() override {
    TracedScene scene;
    scene.views = 3;
    infer_scene(scene);
  }
  ProgramResult pack(const std::string& file, std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"pack", path("out"), "-o", path(file)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum(arguments);
  }
  ProgramResult unpack(const std::string& file, const std::string& folder) const {
    return multum({"unpack", path(file), "-o", path(folder)});
  }
  std::vector<float> frame(const std::string& folder, const std::string& sample) const {
    const std::string picture = path("frame.exr");
    const ProgramResult result = run_program({std::string(MULTUM_BIN_DIR) + "/multum-view", "sample", path(folder),
                                              "--at", sample, "-o", picture, "--context", "osmesa"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const ExrLayers drawn = read_exr_channels(picture, {"R", "G", "B"});
    std::vector<float> values;
    for (const char* c : {"R", "G", "B"})
      values.insert(values.end(), drawn.channels.at(c).begin(), drawn.channels.at(c).end());
    return values;
  }
  // Draws frames from both folders and returns their mean squared difference over all samples, in 8-bit units at gamma
  // 2.2.
  double drawn_mse(const std::string& folder) const {
    double sum = 0.0, count = 0.0;
    for (const char* sample : {"0,0", "0,1", "1,0", "1,1", "2,0", "2,1"}) {
      const std::vector<float> a = frame("out", sample), b = frame(folder, sample);
      for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = static_cast<double>(std::min(255.0f, gamma_coded(a[i])) - std::min(255.0f, gamma_coded(b[i])));
        sum += d * d;
      }
      count += static_cast<double>(a.size());
    }
    return sum / count;
  }
  // Returns the mean squared difference between frames of inferred textures and the ray-traced pictures.
  double inferred_mse() const {
    double sum = 0.0, count = 0.0;
    for (int view = 0; view < 3; ++view)
      for (int light = 0; light < 2; ++light) {
        const ExrLayers traced =
            read_exr_channels(path(fmt::format("renders/rad_v{:02}_p{:02}.exr", view, light)), {"R", "G", "B"});
        const std::vector<float> drawn = frame("out", fmt::format("{},{}", view, light));
        const std::size_t pixels = drawn.size() / 3;
        for (std::size_t i = 0; i < drawn.size(); ++i) {
          const float value = traced.channels.at(std::string(1, "RGB"[i / pixels]))[i % pixels];
          const double d =
              static_cast<double>(std::min(255.0f, gamma_coded(value)) - std::min(255.0f, gamma_coded(drawn[i])));
          sum += d * d;
        }
        count += static_cast<double>(drawn.size());
      }
    return sum / count;
  }
  // Returns the section of a chunk of this object and layer.
  std::size_t chunk_of(const std::string& file, const std::string& text) const {
    const PackedFieldFile packed(path(file));
    for (std::size_t i = 0; i < packed.index().sections().size(); ++i)
      if (packed.section_name(i).find(text) != std::string::npos) return i;
    ADD_FAILURE() << "no section is " << text;
    return 0;
  }
  void flip_byte(const std::string& file, std::size_t at) const {
    std::string bytes = read_bytes(path(file));
    bytes.at(at) = static_cast<char>(bytes[at] ^ 0x40);
    write_bytes(path(file), bytes);
  }
};

TEST_F(PackCommandTest, WhatIsUnpackedDrawsWhatWasPacked) {
  const ProgramResult packed = pack("fine.mpt", {"--lambda", "1"});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  ASSERT_EQ(pack("coarse.mpt", {"--lambda", "300"}).exit_code, 0);
  EXPECT_LT(fs::file_size(path("coarse.mpt")), fs::file_size(path("fine.mpt")) / 2);
  ASSERT_EQ(unpack("fine.mpt", "fine").exit_code, 0);
  ASSERT_EQ(unpack("coarse.mpt", "coarse").exit_code, 0);
  for (const char* sample : {"0,1", "2,0"})  // drawing directly from the packed file gives the same bits
    EXPECT_EQ(frame("coarse.mpt", sample), frame("coarse", sample)) << sample;
  const double fine = drawn_mse("fine"), coarse = drawn_mse("coarse");
  EXPECT_LT(fine, 2.0);
  EXPECT_GT(coarse, 2.0 * fine);
  // The manifest is unchanged, except for the names of textures and the entries about how it was made.
  const InferredManifest before = read_inferred_manifest(path("out/inferred.json"));
  const InferredManifest after = read_inferred_manifest(path("fine/inferred.json"));
  EXPECT_EQ(after.parameters, before.parameters);
  EXPECT_EQ(after.geometry_hash, before.geometry_hash);
  ASSERT_EQ(after.samples.size(), before.samples.size());
  ASSERT_EQ(after.objects.size(), before.objects.size());
  for (std::size_t k = 0; k < before.objects.size(); ++k) {
    ASSERT_EQ(after.objects[k].layers.size(), before.objects[k].layers.size());
    for (std::size_t l = 0; l < before.objects[k].layers.size(); ++l) {
      const auto& was = before.objects[k].layers[l].textures;
      const auto& is = after.objects[k].layers[l].textures;
      // Samples that shared a texture still share a texture.
      for (std::size_t s = 0; s < was.size(); ++s)
        for (std::size_t t = 0; t < was.size(); ++t) EXPECT_EQ(is[s] == is[t], was[s] == was[t]);
    }
  }
  const ProgramResult info = multum({"info", path("fine.mpt")});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  expect_says(info.out, {"packed field", "6 of view, light", "layer 'view_dependent' of object 'board', block 0"});
  const ProgramResult verified = multum({"verify", path("fine.mpt")});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
}

// The coder estimates the loss in drawn frames. The estimate differs from the measured loss by at most a half of it.
TEST_F(PackCommandTest, TargetsAreMet) {
  ASSERT_EQ(pack("any.mpt", {"--lambda", "30"}).exit_code, 0);
  const auto bytes = fs::file_size(path("any.mpt")) * 3 / 4;
  ASSERT_EQ(pack("bytes.mpt", {"--bytes", std::to_string(bytes)}).exit_code, 0);
  EXPECT_LE(fs::file_size(path("bytes.mpt")), bytes);
  EXPECT_GT(fs::file_size(path("bytes.mpt")), bytes * 9 / 10);
  const double raw = 6.0 * 96 * 72 * 3, ratio = raw / static_cast<double>(bytes);
  ASSERT_EQ(pack("ratio.mpt", {"--ratio", fmt::format("{:.3f}", ratio)}).exit_code, 0);
  EXPECT_GE(raw / static_cast<double>(fs::file_size(path("ratio.mpt"))), ratio - 0.001);
  EXPECT_LT(raw / static_cast<double>(fs::file_size(path("ratio.mpt"))), 1.1 * ratio);
  ASSERT_EQ(pack("error.mpt", {"--mse-max", "6"}).exit_code, 0);
  ASSERT_EQ(unpack("error.mpt", "error").exit_code, 0);
  EXPECT_NEAR(drawn_mse("error") / 6.0, 1.0, 0.5);
  expect_refusal(pack("none.mpt", {"--bytes", "200"}), kUsage, {"200 bytes", "cannot be reached"});
  expect_refusal(pack("none.mpt", {"--bytes", "20000", "--ratio", "5"}), kUsage, {"--ratio"});
  EXPECT_FALSE(fs::exists(path("none.mpt")));
}

// At a ratio of 384:1, six small samples get 324 bytes, which is less than the size of their description.
TEST_F(PackCommandTest, TheDefaultRatioGivesWayToTheError) {
  const std::string times = "times the error of the inferred textures";
  const ProgramResult packed = pack("default.mpt", {});
  ASSERT_EQ(packed.exit_code, 0) << packed.err;
  expect_says(packed.out, {"384:1 would add an error of more than 3 " + times, "--ratio 384 forces the ratio"});
  EXPECT_EQ(packed.err.find("warning"), std::string::npos) << packed.err;
  const double inferred = inferred_mse(), added = drawn_mse("default.mpt");
  EXPECT_LT(added, 3.0 * inferred);
  EXPECT_GT(added, 0.05 * inferred);  // the error is not needlessly low
  // The file has the requested size, and the error is printed.
  const auto bytes = fs::file_size(path("default.mpt")) / 2;
  const ProgramResult small = pack("small.mpt", {"--bytes", std::to_string(bytes)});
  ASSERT_EQ(small.exit_code, 0) << small.err;
  expect_says(small.err, {"warning", "small.mpt: packing adds an MSE of about", times, "Without --ratio, --bytes"});
  EXPECT_GT(drawn_mse("small.mpt"), added);
  const ProgramResult by_error = pack("error.mpt", {"--mse-max", "6"});
  EXPECT_EQ(by_error.err.find("warning"), std::string::npos) << by_error.err;
  expect_refusal(pack("none.mpt", {"--ratio", "384"}), kUsage,
                 {"a ratio of 384 (324 bytes) cannot be reached", "--mse-max"});
  // Without a report, the allowed error is not known.
  fs::remove(path("out/report.json"));
  expect_refusal(pack("none.mpt", {}), kUsage, {"a ratio of 384", "cannot be reached", "--ratio", "--mse-max"});
}

TEST_F(PackCommandTest, BytesAreTheSameForAnyNumberOfThreadsAndBlocksAreCut) {
  ASSERT_EQ(pack("one.mpt", {"--lambda", "50", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(pack("two.mpt", {"--lambda", "50", "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(read_bytes(path("one.mpt")), read_bytes(path("two.mpt")));
  ASSERT_EQ(pack("blocks.mpt", {"--lambda", "1", "--block", "2"}).exit_code, 0);
  const PackedFieldFile packed(path("blocks.mpt"));
  for (const PackedLayer& layer : packed.description().layers)
    EXPECT_EQ(layer.blocks.size(), layer.name == "diffuse" ? 1u : 2u) << layer.name;
  ASSERT_EQ(unpack("blocks.mpt", "blocks").exit_code, 0);
  EXPECT_LT(drawn_mse("blocks"), 2.0);
}

// With the option, objects' blocks begin at different samples, but only along a parameter with several blocks.
TEST_F(PackCommandTest, BlocksAreStaggeredWhenAsked) {
  for (const char* folder : {"renders", "out"}) fs::remove_all(path(folder));
  TracedScene scene;
  scene.views = scene.lights = 3;  // the textures of both objects vary with the light
  infer_scene(scene);
  ASSERT_EQ(pack("no.mpt", {"--lambda", "50"}).exit_code, 0);
  ASSERT_EQ(pack("whole.mpt", {"--lambda", "50", "--stagger", "yes"}).exit_code, 0);
  EXPECT_EQ(read_bytes(path("no.mpt")), read_bytes(path("whole.mpt")));
  ASSERT_EQ(pack("one.mpt", {"--lambda", "1", "--block", "2", "--stagger", "yes", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(pack("two.mpt", {"--lambda", "1", "--block", "2", "--stagger", "yes", "--threads", "2"}).exit_code, 0);
  EXPECT_EQ(read_bytes(path("one.mpt")), read_bytes(path("two.mpt")));
  const PackedFieldFile packed(path("one.mpt"));
  std::map<std::size_t, std::set<int>> borders;  // the objects' block borders along the light parameter
  for (const PackedLayer& layer : packed.description().layers)
    for (const FieldBlock& block : layer.blocks)
      if (block.begin[1] > 0) borders[layer.object].insert(block.begin[1]);
  EXPECT_EQ(borders[0], (std::set<int>{2}));
  EXPECT_EQ(borders[1], (std::set<int>{1}));
  ASSERT_EQ(unpack("one.mpt", "one").exit_code, 0);
  EXPECT_LT(drawn_mse("one"), 2.0);
}

// With --alpha, each object's mean error is at most --alpha times the mean error of all objects. Without --alpha, some
// object exceeds this limit.
TEST_F(PackCommandTest, AlphaHoldsWhatAnObjectMayBeOff) {
  FieldPackSettings settings;
  settings.folder = path("out");
  settings.output = path("field.mpt");
  settings.target.lambda = 100.0;
  settings.alpha = 0.0;
  const FieldPackReport free = pack_field(settings, nullptr);
  double most = 0.0, error = 0.0, pixels = 0.0;
  for (const PackedObjectReport& object : free.objects) {
    most = std::max(most, object.mse / free.mse_covered);
    error += object.mse * object.pixels;
    pixels += object.pixels;
    EXPECT_EQ(object.lambda, 100.0);
  }
  EXPECT_NEAR(error / pixels, free.mse_covered, 1e-6 * free.mse_covered);
  ASSERT_GT(most, 1.05) << "nothing to hold";
  settings.alpha = 1.0 + 0.5 * (most - 1.0);
  for (const bool by_bytes : {false, true}) {
    if (by_bytes) {
      settings.target = {};
      settings.target.bytes = static_cast<double>(free.bytes);
    }
    const FieldPackReport held = pack_field(settings, nullptr);
    EXPECT_TRUE(held.is_alpha_met);
    bool any = false;
    for (const PackedObjectReport& object : held.objects) {
      EXPECT_LE(object.mse, settings.alpha * held.mse_covered) << object.object;
      any |= object.lambda < held.lambda;
    }
    EXPECT_TRUE(any);
    EXPECT_TRUE(!by_bytes || held.bytes <= free.bytes);
  }
  expect_refusal(pack("field.png", {"--lambda", "100"}), kUsage, {"field.png", ".mpt"});
  expect_refusal(pack("none.mpt", {"--alpha", "0.5"}), kUsage, {"--alpha", "0.5", "above 1"});
}

TEST_F(PackCommandTest, CodersPyramidsAndLoopsAreChosen) {
  const auto cost = [&](std::vector<std::string> more) {
    more.insert(more.end(), {"--lambda", "50", "--alpha", "0", "-v"});
    const ProgramResult result = pack("field.mpt", more);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(multum({"verify", path("field.mpt")}).exit_code, 0);
    const std::size_t at = result.out.find("MSE of about ");
    return std::stod(result.out.substr(at + 13)) * 6.0 * 96 * 72 * 3 +
           8.0 * 50.0 * static_cast<double>(fs::file_size(path("field.mpt")));
  };
  const auto coders = [&] {
    PackedFieldFile packed(path("field.mpt"));
    std::set<ImageCoder> found;
    for (std::size_t l = 0; l < packed.description().layers.size(); ++l)
      if (const auto chunk = packed.chunk(l, 0)) found.insert(chunk->format().coder);
    return found;
  };
  const double best = cost({}), plain = cost({"--pyramid", "plain"});
  EXPECT_LE(best, 1.001 * plain);
  EXPECT_LE(plain, 1.02 * cost({"--pyramid", "none"}));
  cost({"--coder", "dct"});
  EXPECT_EQ(coders(), std::set<ImageCoder>{ImageCoder::kDct});
  EXPECT_LE(best, 1.001 * cost({"--coder", "wavelet"}));
  EXPECT_EQ(coders(), std::set<ImageCoder>{ImageCoder::kWavelet});
  EXPECT_GT(cost({"--pyramid", "plain", "--loop", "open"}), plain);
}

TEST_F(PackCommandTest, ADamagedChunkCostsThatChunkAndIsNamed) {
  ASSERT_EQ(pack("field.mpt", {"--lambda", "50"}).exit_code, 0);
  const std::string name = "layer 'diffuse' of object 'ground'";
  const std::size_t number = chunk_of("field.mpt", name);
  const auto offset = PackedFieldFile(path("field.mpt")).index().sections()[number].offset;
  flip_byte("field.mpt", offset + 30);
  const ProgramResult verified = multum({"verify", path("field.mpt")});
  expect_refusal(verified, kVerification, {"field.mpt"});
  std::size_t failed = 0;
  for (std::size_t at = 0; (at = verified.out.find("FAILED", at)) != std::string::npos; ++at) ++failed;
  EXPECT_EQ(failed, 1u) << verified.out;
  expect_says(verified.out, {fmt::format("FAILED section {}", number), name});
  expect_refusal(unpack("field.mpt", "rest"), kVerification, {"field.mpt", fmt::format("section {}", number), name});
  for (const InferredObject& object : read_inferred_manifest(path("rest/inferred.json")).objects)
    for (const InferredLayer& layer : object.layers)
      for (const std::string& texture : layer.textures) {
        EXPECT_EQ(texture.empty(), object.name == "ground" && layer.name == "diffuse");
        if (!texture.empty()) {
          EXPECT_NO_THROW(read_inferred_texture(path("rest/" + texture)));
        }
      }
}

// Drawing straight from the file leaves out the same textures as unpacking, with the same message.
TEST_F(PackCommandTest, ADamagedChunkIsLeftOutOfPictures) {
  ASSERT_EQ(pack("field.mpt", {"--lambda", "50"}).exit_code, 0);
  const std::vector<float> whole = frame("field.mpt", "1,0");
  const std::string name = "layer 'diffuse' of object 'ground'";
  const auto offset = PackedFieldFile(path("field.mpt")).index().sections()[chunk_of("field.mpt", name)].offset;
  flip_byte("field.mpt", offset + 30);
  ASSERT_EQ(unpack("field.mpt", "rest").exit_code, exit_code(ErrorCode::kVerification));
  const ProgramResult drawn = run_program({std::string(MULTUM_BIN_DIR) + "/multum-view", "sample", path("field.mpt"),
                                           "--at", "1,0", "-o", path("damaged.exr"), "--context", "osmesa"});
  EXPECT_EQ(drawn.exit_code, exit_code(ErrorCode::kVerification));
  expect_says(drawn.err, {"field.mpt", name, "left out"});
  const std::vector<float> rest = frame("rest", "1,0");
  EXPECT_EQ(read_bytes(path("damaged.exr")), read_bytes(path("frame.exr")));
  EXPECT_NE(rest, whole);
}

TEST_F(PackCommandTest, DamagedCutAndOtherFilesAreRefused) {
  ASSERT_EQ(pack("field.mpt", {"--lambda", "50"}).exit_code, 0);
  const std::string whole = read_bytes(path("field.mpt"));
  const auto refused = [&](const std::string& bytes, const std::vector<std::string>& parts) {
    write_bytes(path("bad.mpt"), bytes);
    expect_refusal(unpack("bad.mpt", "bad"), kInput, parts);
    EXPECT_FALSE(fs::exists(path("bad"))) << "a refused field must write nothing";
  };
  refused(whole.substr(0, whole.size() - 10), {"bad.mpt", fmt::format("has {} bytes", whole.size() - 10), "section"});
  refused(whole.substr(0, 20), {"bad.mpt", "cut short within its index"});
  refused(whole + "x", {"bad.mpt", fmt::format("its index states {}", whole.size())});
  refused("MPTF", {"bad.mpt", "cut short"});
  refused("some text, longer than a head", {"bad.mpt", "not a packed field"});
  std::string damaged = whole;
  damaged[12] = static_cast<char>(damaged[12] ^ 1);
  refused(damaged, {"bad.mpt", "checksum of its index differs"});
  damaged = whole;
  const std::size_t description = PackedFieldFile(path("field.mpt")).index().sections().front().offset;
  damaged[description + 40] = static_cast<char>(damaged[description + 40] ^ 1);
  refused(damaged, {"bad.mpt", "section 0 (description)", "checksum"});
  expect_refusal(unpack("none.mpt", "bad"), kInput, {"none.mpt", "cannot be read"});
  const std::string manifest = read_bytes(path("out/inferred.json"));
  expect_refusal(unpack("field.mpt", "out"), kUsage, {"out/inferred.json", "already exists"});
  expect_refusal(pack("out/inferred.json", {"--lambda", "50"}), kUsage, {"inferred.json"});
  EXPECT_EQ(read_bytes(path("out/inferred.json")), manifest);
  fs::remove(path("out/matrices/v01_p00_board.fmx"));
  expect_refusal(pack("again.mpt", {"--lambda", "50"}), kInput, {"v01_p00_board.fmx"});
  fs::remove(path("out/inferred.json"));
  expect_refusal(pack("again.mpt", {"--lambda", "50"}), kInput, {"inferred.json"});
  EXPECT_FALSE(fs::exists(path("again.mpt")));
}

TEST_F(PackCommandTest, CancelledLeavesNothing) {
  // Stops the packing when the first chunk is finished, or before it is started.
  const auto stops_in = [](const std::string& stage, std::uint64_t units) {
    return Progress(
        [=](const ProgressEvent& event) { return !(event.stage.starts_with(stage) && event.units_done >= units); });
  };
  FieldPackSettings settings;
  settings.folder = path("out");
  settings.output = path("field.mpt");
  settings.target.lambda = 50.0;
  for (const std::uint64_t units : {0u, 1u}) {
    Progress progress = stops_in("code", units);
    EXPECT_THROW(pack_field(settings, &progress), Cancelled);
  }
  Progress reading = stops_in("read", 0);
  EXPECT_THROW(pack_field(settings, &reading), Cancelled);
  for (const auto& entry : fs::directory_iterator(path("")))
    EXPECT_EQ(entry.path().filename().string().find(".mpt"), std::string::npos) << entry.path();
  pack_field(settings, nullptr);
  Progress unpacking = stops_in("unpack", 1);
  EXPECT_THROW(unpack_field(settings.output, path("unpacked"), 1, &unpacking), Cancelled);
  EXPECT_FALSE(fs::exists(path("unpacked/inferred.json")));
}

}  // namespace
}  // namespace multum::testing
