// SPDX-License-Identifier: Apache-2.0
// Tests image files that a child process decodes. The numbers and error messages equal those of decoding in this
// process. However the child ends, the result is an error message that names the file.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>

#include "host/formats/decoder/libraries/oiio_image_file.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/image/files/image_file.h"
#include "host/formats/image/image_reader.h"
#include "host/foundation/base/processes/sanitizers.h"
#include "tests/fixtures/shared_data.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

DecodingChild child_of(const std::string& program) {
  DecodingChild child;
  child.program = std::string(MULTUM_BIN_DIR) + "/" + program;
  return child;
}

class ImageDecodingTest : public ::testing::Test {
 protected:
  ImageDecodingTest() { set_image_opener(open_in_child(child_of("multum-decode"))); }
  ~ImageDecodingTest() override { set_image_opener(open_in_child({})); }

  std::string write(const std::string& name, const TestImage& image) const {
    write_test_image(folder_ / name, image);
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

struct Picture {
  std::string format;
  std::string samples;
};

Picture read_picture(const std::string& path) {
  ImageReader reader(path, {});
  Picture picture{reader.info().format, {}};
  reader.read(
      [&](const RawBand& band) {
        picture.samples.append(reinterpret_cast<const char*>(band.samples),
                               reader.info().row_bytes * static_cast<std::size_t>(band.row_count));
      },
      nullptr);
  return picture;
}

std::string refusal_of(const std::string& path) {
  try {
    read_picture(path);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput) << error.what();
    EXPECT_NE(std::string(error.what()).find(fs::path(path).filename().string()), std::string::npos) << error.what();
    return error.what();
  }
}

/// Returns the id of the decoding child, the only child of this process.
pid_t decoder_pid() {
  std::ifstream children("/proc/self/task/" + std::to_string(::getpid()) + "/children");
  pid_t pid = 0;
  children >> pid;
  return pid;
}

TEST_F(ImageDecodingTest, FilesReadAsInThisProcess) {
  TestImage image = normal_image(150, 217);
  std::vector<std::string> paths = {write("a.png", image), write("a.webp", image), write("a.jpg", image)};
  image.type = OIIO::TypeDesc::UINT16;
  paths.push_back(write("b.png", image));
  paths.push_back(write("b.tif", image));
  image.type = OIIO::TypeDesc::HALF;
  paths.push_back(write("c.exr", image));
  image.tile_size = 32;
  paths.push_back(write("d.exr", image));
  const pid_t first = (read_picture(paths[0]), decoder_pid());
  EXPECT_GT(first, 0);
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const Picture there = read_picture(path);
    const auto channels_there =
        path.ends_with(".exr") ? read_exr_channels(path, {"G"}).channels : decltype(ExrLayers::channels){};
    set_image_opener(open_library_image);
    const Picture here = read_picture(path);
    const auto channels_here =
        path.ends_with(".exr") ? read_exr_channels(path, {"G"}).channels : decltype(ExrLayers::channels){};
    set_image_opener(open_in_child(child_of("multum-decode")));
    EXPECT_EQ(there.format, here.format);
    EXPECT_TRUE(there.samples == here.samples);
    EXPECT_TRUE(channels_there == channels_here);
  }
  EXPECT_EQ(decoder_pid(), first) << "one child reads them all";
}

TEST_F(ImageDecodingTest, RefusalsSayTheSame) {
  const std::string whole = read_bytes(write("a.png", normal_image(64, 64)));
  write_bytes(folder_ / "cut.png", whole.substr(0, whole.size() / 2));
  write_bytes(folder_ / "text.png", "this text is not a picture");
  TestImage many = normal_image(8, 8);
  many.channels = 6;
  many.channel_names = {"a", "b", "c", "d", "e", "f"};
  many.values.resize(8 * 8 * 6);
  const std::vector<std::string> paths = {folder_ / "none.png", folder_ / "cut.png", folder_ / "text.png",
                                          write("many.exr", many)};
  for (const std::string& path : paths) {
    const std::string there = refusal_of(path);
    set_image_opener(open_library_image);
    EXPECT_EQ(there, refusal_of(path));
    EXPECT_NE(there, "");
    set_image_opener(open_in_child(child_of("multum-decode")));
  }
}

// Truncated files, flipped bits and absurd numbers give either a picture or an error, and the next file is read.
TEST_F(ImageDecodingTest, BrokenFilesEndInARefusal) {
  std::mt19937 random(20260101);
  const TestImage image = normal_image(40, 30);
  int refused = 0;
  for (const char* name : {"a.png", "a.jpg", "a.webp", "a.tif", "a.exr"}) {
    const std::string whole = read_bytes(write(name, image));
    const std::string path = folder_ / (std::string("broken_") + name);
    for (int i = 0; i < 12; ++i) {
      std::string broken = whole;
      for (int k = 0; k < 1 + i; ++k) {
        const std::size_t at = random() % std::min<std::size_t>(broken.size(), i % 2 == 0 ? 400 : broken.size());
        if (i % 3 == 2) broken.replace(at, 4, std::string(4, i % 2 == 0 ? '\xff' : '\x7f'));
        else broken[at] = static_cast<char>(broken[at] ^ (1 << random() % 8));
      }
      if (i % 4 == 3) broken.resize(random() % broken.size());
      write_bytes(path, broken);
      refused += refusal_of(path).empty() ? 0 : 1;
    }
    EXPECT_EQ(refusal_of(folder_ / name), "");
  }
  EXPECT_GT(refused, 10);
}

// The system kills processes when memory runs out, so the same file may succeed on another machine.
TEST_F(ImageDecodingTest, AChildThatIsKilledMidWayIsAnErrorOfTheMachine) {
  const std::string path = write("long.tif", normal_image(64, 9000));
  ImageReader reader(path, {});
  bool is_killed = false;
  expect_error(ErrorCode::kEnvironment, {"long.tif: ", "decoding", "signal 9", "Killed", "memory", "expected"}, [&] {
    reader.read(
        [&](const RawBand&) {
          if (!is_killed) ::kill(decoder_pid(), SIGKILL);
          is_killed = true;
        },
        nullptr);
  });
  EXPECT_TRUE(is_killed);
  EXPECT_EQ(refusal_of(path), "") << "a new child decodes the next file";
}

TEST_F(ImageDecodingTest, WhatEndsAChildIsARefusalOfItsFile) {
  DecodingChild drill = child_of("failing_helper");
  drill.memory_base = std::uint64_t{256} << 20;
  drill.time_base_ms = 700;
  set_image_opener(open_in_child(drill));
  const TestImage image = normal_image(8, 8);
  for (const auto& [name, reason] : std::vector<std::pair<std::string, std::string>>{
#ifndef MULTUM_SHADOW_MEMORY
           {"abort", "was terminated by signal 6 (Aborted): a library's last words"},
           {"segfault", "was terminated by signal 11 (Segmentation fault)"},
#endif
           {"hang", "took more than 700 ms and was terminated"},
           {"exit", "ended with exit code 7"},
           {"nonsense", "returned 8 invalid bytes"}}) {
    const std::string refusal = refusal_of(write(name + ".png", image));
    EXPECT_NE(refusal.find(reason), std::string::npos) << refusal;
    EXPECT_NE(refusal.find("expected"), std::string::npos) << refusal;
  }
}

TEST_F(ImageDecodingTest, NoDecoderIsAnErrorOfTheMachine) {
  set_image_opener(open_in_child(child_of("no-such-decoder")));
  expect_error(ErrorCode::kEnvironment, {"no-such-decoder: ", "started"},
               [&] { read_picture(write("a.png", normal_image(8, 8))); });
}

// None of our decoders gives these answers.
TEST_F(ImageDecodingTest, DescriptionsAreChecked) {
  ImagePart part;
  part.width = part.height = part.full_width = part.full_height = 8;
  part.base_type = OIIO::TypeDesc::UINT8;
  part.channel_names = {"R"};
  const auto refused = [&](const std::string& why, const ImagePart& wrong) {
    expect_error(ErrorCode::kInput, {"a.png: ", why}, [&] { check_described("a.png", {"png", 100, {wrong}}, 1000); });
  };
  EXPECT_NO_THROW(check_described("a.png", {"png", 100, {part}}, 1000));
  refused("found 0 channels", [&] {
    auto p = part;
    p.channel_names.clear();
    return p;
  }());
  refused("found 8 x -1 texels", [&] {
    auto p = part;
    p.height = -1;
    return p;
  }());
  refused("expected at most 1000 in all", [&] {
    auto p = part;
    p.width = 500;
    return p;
  }());
  refused("expected positions within 2^30", [&] {
    auto p = part;
    p.y = -2000000000;
    return p;
  }());
  refused("in tiles of 8 x -8", [&] {
    auto p = part;
    p.tile_width = 8, p.tile_height = -8;
    return p;
  }());
  refused("number of channel types", [&] {
    auto p = part;
    p.channel_types = {2, 2};
    return p;
  }());
  refused("its alpha", [&] {
    auto p = part;
    p.alpha_channel = 1;
    return p;
  }());
  refused("found samples of type", [&] {
    auto p = part;
    p.base_type = 1000;
    return p;
  }());
}

TEST_F(ImageDecodingTest, DamagedFilesOfTheSharedData) {
  const std::string data = shared_data();
  if (data.empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder of damaged files";
  int count = 0;
  for (const char* kind : {"/bad/image", "/bad/exr", "/exr"})
    for (const fs::directory_entry& entry : fs::directory_iterator(data + kind)) {
      SCOPED_TRACE(entry.path().string());
      const auto start = std::chrono::steady_clock::now();
      const std::string refusal = refusal_of(entry.path().string());
      const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
      EXPECT_LT(time.count(), 40.0);
      std::printf("%-24.24s %5.2f s %s\n", entry.path().filename().c_str(), time.count(),
                  refusal.empty() ? "read" : refusal.c_str() + entry.path().string().size());
      ++count;
    }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace multum::testing
