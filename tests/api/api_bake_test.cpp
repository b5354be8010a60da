// SPDX-License-Identifier: Apache-2.0
// Tests bakes through multum.h. They give the same texels as the program. Also tests progress, cancelling, the log, and
// calls from several threads.
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/api/api_fixture.h"

namespace multum::testing {
namespace {

const std::string kProgram = std::string(MULTUM_BIN_DIR) + "/multum";

int run(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()); }

std::string text_of(const Owned<multum_map>& map, const char* key) { return multum_map_text(map.get(), key); }

// A PNG that `multum testmap` wrote. The program and the library both bake it.
std::string test_map(const TestFolder& folder) {
  const std::string file = folder.file("map_normal.png");
  EXPECT_EQ(run(kProgram + " testmap --size 64 --write-green up -o " + folder.file("map")), 0);
  return file;
}

Owned<multum_map> bake_file(multum_device* device, const std::string& input, const multum_values* values,
                            const char* output) {
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.input = input.c_str();
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(multum_bake(device, &maps, values, output, nullptr, &map, error.place()), MULTUM_OK) << error.message();
  return Owned<multum_map>(map);
}

TEST(ApiBakeTest, MakesTheTexelsOfTheProgram) {
  const TestFolder folder;
  const std::string input = test_map(folder), by_program = folder.file("program.ndf.exr");
  ASSERT_EQ(run(kProgram + " bake --lobes 3 -q " + input + " -o " + by_program), 0);
  multum_map* opened = nullptr;
  ASSERT_EQ(multum_map_open(by_program.c_str(), &opened, nullptr), MULTUM_OK);
  const Owned<multum_map> program(opened);
  const Owned<multum_device> device = open_device();
  const Owned<multum_values> values = bake_values();
  ASSERT_EQ(multum_values_set_number(values.get(), "lobes", 3, nullptr), MULTUM_OK);
  const Owned<multum_map> library =
      bake_file(device.get(), input, values.get(), folder.file("library.ndf.exr").c_str());
  EXPECT_EQ(text_of(library, "content_hash"), text_of(program, "content_hash"));
  EXPECT_EQ(text_of(library, "content_hash").size(), 64u);
  EXPECT_EQ(text_of(library, "settings"), text_of(program, "settings"));
  EXPECT_EQ(text_of(library, "source_hash"), text_of(program, "source_hash"));
  EXPECT_EQ(text_of(library, "measured_error"), text_of(program, "measured_error"));
  EXPECT_EQ(multum_map_info(library.get()).lobe_count, 3);
  EXPECT_NE(text_of(library, "report").find("\"stages\""), std::string::npos);
}

TEST(ApiBakeTest, MemoryAndTemporaryFileGiveTheSameTexels) {
  const TestFolder folder;
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(32);
  const multum_image image = image_of(pixels, 32);
  const Owned<multum_map> kept = bake(device.get(), image, nullptr, folder.file("kept.ndf.exr").c_str());
  Owned<multum_map> temporary = bake(device.get(), image, nullptr);
  EXPECT_EQ(text_of(kept, "content_hash"), text_of(temporary, "content_hash"));
  EXPECT_EQ(text_of(kept, "source_name"), "normals");
  // If rows are passed from the bottom to the top, with a negative row stride, the map is flipped.
  std::vector<float> flipped;
  for (int y = 31; y >= 0; --y) flipped.insert(flipped.end(), pixels.begin() + y * 96, pixels.begin() + (y + 1) * 96);
  multum_image from_below = image_of(flipped, 32);
  from_below.pixels = flipped.data() + 31 * 96;
  from_below.row_bytes = -96 * static_cast<std::ptrdiff_t>(sizeof(float));
  EXPECT_EQ(text_of(bake(device.get(), from_below, nullptr), "content_hash"), text_of(kept, "content_hash"));
  ASSERT_EQ(multum_map_save(temporary.get(), folder.file("saved.ndf.exr").c_str(), nullptr), MULTUM_OK);
  temporary.reset();
  multum_map* saved = nullptr;
  ASSERT_EQ(multum_map_open(folder.file("saved.ndf.exr").c_str(), &saved, nullptr), MULTUM_OK);
  EXPECT_EQ(text_of(Owned<multum_map>(saved), "content_hash"), text_of(kept, "content_hash"));
  EXPECT_EQ(run(kProgram + " verify " + folder.file("saved.ndf.exr")), 0);
}

struct Heard {
  int calls = 0, cancel_at = 1 << 30;
  double last = 0.0;
  std::vector<std::string> warnings, infos;
};

int hear_progress(void* user, const char* stage, double share) {
  Heard& heard = *static_cast<Heard*>(user);
  EXPECT_NE(stage, nullptr);
  EXPECT_LE(share, 1.0);
  heard.last = share;
  return ++heard.calls >= heard.cancel_at ? 1 : 0;
}
void hear_log(void* user, multum_log_kind kind, const char* message) {
  Heard& heard = *static_cast<Heard*>(user);
  if (kind == MULTUM_WARNING) heard.warnings.push_back(message);
  if (kind == MULTUM_INFO) heard.infos.push_back(message);
}

multum_callbacks callbacks_of(Heard& heard) {
  multum_callbacks callbacks = MULTUM_CALLBACKS_INIT;
  callbacks.user = &heard;
  callbacks.progress = hear_progress;
  callbacks.log = hear_log;
  return callbacks;
}

TEST(ApiBakeTest, ReportsProgressAndLog) {
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(32);
  const multum_image image = image_of(pixels, 32);
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &image;
  Heard heard;
  const multum_callbacks callbacks = callbacks_of(heard);
  multum_map* map = nullptr;
  ASSERT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, &callbacks, &map, nullptr), MULTUM_OK);
  multum_map_free(map);
  EXPECT_GT(heard.calls, 3);
  EXPECT_EQ(heard.last, 1.0);
  ASSERT_FALSE(heard.infos.empty());
  EXPECT_EQ(heard.infos[0].rfind("normals: 32 x 32", 0), 0u) << heard.infos[0];
}

TEST(ApiBakeTest, CancellingLeavesNothingAndTheDeviceUsable) {
  const TestFolder folder;
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(32);
  const multum_image image = image_of(pixels, 32);
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &image;
  Heard heard;
  heard.cancel_at = 3;
  const multum_callbacks callbacks = callbacks_of(heard);
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(
      multum_bake(device.get(), &maps, nullptr, folder.file("out/a.ndf.exr").c_str(), &callbacks, &map, error.place()),
      MULTUM_CANCELLED);
  EXPECT_EQ(error.status(), MULTUM_CANCELLED);
  EXPECT_EQ(map, nullptr);
  EXPECT_EQ(folder.file_count(), 0u);  // the new folder is removed too
  EXPECT_NE(bake(device.get(), image, nullptr), nullptr);
}

TEST(ApiBakeTest, ThreadsHaveTheirOwnLogs) {
  constexpr int kThreads = 4;
  std::vector<std::string> hashes(kThreads);
  std::vector<Heard> heard(kThreads);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&, i] {
      const Owned<multum_device> device = open_device();
      const int size = 16 << (i % 2);
      const std::vector<float> pixels = wavy_normals(size);
      const multum_image image = image_of(pixels, size);
      multum_maps maps = MULTUM_MAPS_INIT;
      maps.normals = &image;
      const multum_callbacks callbacks = callbacks_of(heard[static_cast<std::size_t>(i)]);
      multum_map* map = nullptr;
      ASSERT_EQ(multum_bake(device.get(), &maps, nullptr, nullptr, &callbacks, &map, nullptr), MULTUM_OK);
      hashes[static_cast<std::size_t>(i)] = multum_map_text(map, "content_hash");
      multum_map_free(map);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(hashes[0], hashes[2]);
  EXPECT_EQ(hashes[1], hashes[3]);
  EXPECT_NE(hashes[0], hashes[1]);
  for (int i = 0; i < kThreads; ++i) {
    const std::vector<std::string>& infos = heard[static_cast<std::size_t>(i)].infos;
    const std::string mine = "normals: " + std::to_string(16 << (i % 2)) + " x";
    int count = 0;
    for (const std::string& line : infos) count += line.rfind("normals: ", 0) == 0 ? 1 : 0;
    EXPECT_EQ(count, 1);
    EXPECT_EQ(infos.at(0).rfind(mine, 0), 0u) << infos[0];
  }
}

TEST(ApiBakeTest, ThreadsMayShareADeviceAndAMap) {
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(16);
  const multum_image image = image_of(pixels, 16);
  const Owned<multum_map> shared = bake(device.get(), image, nullptr);
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      multum_lobes lobes;
      for (int k = 0; k < 200; ++k)
        if (multum_map_lookup(shared.get(), 0.01 * k, 0.3, 0.02 * k, &lobes, nullptr) != MULTUM_OK) ++wrong;
      const Owned<multum_map> mine = bake(device.get(), image, nullptr);
      if (text_of(mine, "content_hash") != text_of(shared, "content_hash")) ++wrong;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(ApiBakeTest, ExportsAndMeasures) {
  const TestFolder folder;
  const Owned<multum_device> device = open_device();
  const std::vector<float> pixels = wavy_normals(32);
  const multum_image image = image_of(pixels, 32);
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &image;
  multum_text* report = nullptr;
  MadeError error;
  ASSERT_EQ(
      multum_export(device.get(), &maps, nullptr, folder.file("material").c_str(), nullptr, &report, error.place()),
      MULTUM_OK)
      << error.message();
  EXPECT_NE(std::string(multum_text_get(report)).find("\"files\""), std::string::npos);
  multum_text_free(report);
  EXPECT_TRUE(std::filesystem::exists(folder.file("material/normal_00.png"))) << "first level of the normals";
  const Owned<multum_map> baked = bake(device.get(), image, nullptr, folder.file("a.ndf.exr").c_str());
  multum_text* errors = nullptr;
  ASSERT_EQ(
      multum_measure(device.get(), folder.file("a.ndf.exr").c_str(), &maps, nullptr, nullptr, &errors, error.place()),
      MULTUM_OK)
      << error.message();
  EXPECT_EQ(std::string(multum_text_get(errors)), text_of(baked, "measured_error"));
  multum_text_free(errors);
}

}  // namespace
}  // namespace multum::testing
