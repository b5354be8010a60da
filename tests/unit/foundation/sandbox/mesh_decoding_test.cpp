// SPDX-License-Identifier: Apache-2.0
// Tests meshes that a child process reads. The numbers and error messages equal those of reading in this process.
// However the child ends, and whatever wrong answer it gives, the result is an error message that names the file.
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "host/formats/decoder/libraries/mesh_readers.h"
#include "host/formats/mesh/mesh_messages.h"
#include "host/formats/mesh/mesh_source.h"
#include "host/foundation/base/processes/sanitizers.h"
#include "tests/fixtures/shared_data.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

DecodingChild child_of(const std::string& program) { return {std::string(MULTUM_BIN_DIR) + "/" + program}; }

std::string refusal_of(const std::string& path, const std::function<void()>& read) {
  try {
    read();
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput) << error.what();
    EXPECT_EQ(std::string(error.what()).find(path), 0u) << error.what();
    return error.what();
  }
}

std::string refusal_of(const std::string& path) {
  return refusal_of(path, [&] { read_mesh(path); });
}

class MeshDecodingTest : public ::testing::Test {
 protected:
  MeshDecodingTest() { set_mesh_child(child_of("multum-decode")); }
  ~MeshDecodingTest() override { set_mesh_child({}); }

  std::string write(const std::string& name, const std::string& text) const {
    write_bytes(folder_ / name, text);
    return folder_ / name;
  }
  /// Writes size * size bent squares.
  std::string write_grid(const std::string& name, int size) const {
    std::string text;
    for (int y = 0; y <= size; ++y)
      for (int x = 0; x <= size; ++x) text += fmt::format("v {} {} {}\nvt {} {}\n", x, y, x * y % 7, 0.1 * x, 0.1 * y);
    for (int y = 0; y < size; ++y)
      for (int x = 1; x <= size; ++x) {
        const int a = y * (size + 1) + x, b = a + size + 1;
        text += fmt::format("f {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", a, a + 1, b + 1, b);
      }
    return write(name, text);
  }

  TemporaryFolder folder_;
};

TEST_F(MeshDecodingTest, FilesReadAsInThisProcess) {
  GltfScene two;
  two.nodes = R"({"name":"group","translation":[0,0,5],"children":[1,2]},)"
              R"({"name":"left","mesh":0,"translation":[-1,0,0]},{"name":"right","mesh":0,"scale":[2,2,2]})";
  std::vector<std::string> paths = {write("two.gltf", gltf_text(two)), write_grid("grid.obj", 20)};
  if (const std::string data = shared_data(); !data.empty())
    for (const char* name : {"spot.obj", "pc_NormalTangentTest.glb", "dutch_ship/dutch_ship_medium_1k.gltf"})
      paths.push_back(data + "/mesh/" + name);
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const TriangleMesh there = read_mesh(path), here = import_mesh(path, 0);
    EXPECT_TRUE(there.positions == here.positions && there.normals == here.normals && there.uvs == here.uvs);
    EXPECT_TRUE(there.tangents == here.tangents && there.indices == here.indices);
    ASSERT_EQ(there.parts.size(), here.parts.size());
    for (std::size_t i = 0; i < here.parts.size(); ++i) {
      EXPECT_EQ(there.parts[i].material, here.parts[i].material);
      EXPECT_EQ(there.parts[i].material_index, here.parts[i].material_index);
      EXPECT_EQ(there.parts[i].first_index, here.parts[i].first_index);
      EXPECT_EQ(there.parts[i].index_count, here.parts[i].index_count);
    }
    const ObjectMeshes objects_there = read_object_meshes(path, 0), objects_here = import_object_meshes(path, 0);
    ASSERT_EQ(objects_there.size(), objects_here.size());
    for (std::size_t i = 0; i < objects_here.size(); ++i) {
      EXPECT_EQ(objects_there[i].name, objects_here[i].name);
      EXPECT_TRUE(objects_there[i].positions == objects_here[i].positions);
      EXPECT_TRUE(objects_there[i].uvs == objects_here[i].uvs && objects_there[i].indices == objects_here[i].indices);
      EXPECT_EQ(objects_there[i].object_to_world, objects_here[i].object_to_world);
    }
  }
}

TEST_F(MeshDecodingTest, RefusalsSayTheSame) {
  GltfScene far;
  far.last_index = 9;
  for (const std::string& path : {folder_ / "none.obj", write("cut.glb", "glTF"), write("bad.gltf", "{\"asset\": "),
                                  write("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
                                  write("far.gltf", gltf_text(far)), write("text.obj", "no mesh")}) {
    const std::string there = refusal_of(path);
    EXPECT_EQ(there, refusal_of(path, [&] { import_mesh(path, 0); }));
    EXPECT_NE(there, "");
  }
}

TEST_F(MeshDecodingTest, WhatEndsAChildIsARefusalOfItsFile) {
  DecodingChild drill = child_of("failing_helper");
  drill.time_base_ms = 700;
  set_mesh_child(drill);
  for (const auto& [name, reason] : std::vector<std::pair<std::string, std::string>>{
#ifndef MULTUM_SHADOW_MEMORY
           {"segfault",
            "decoding failed (the decoder was terminated by signal 11 (Segmentation fault)); expected an undamaged "
            "file that assimp can decode within"},
#endif
           {"hang", "took more than 700 ms and was terminated"},
           {"nonsense", "returned 8 invalid bytes"}}) {
    const std::string refusal = refusal_of(write(name + ".obj", ""));
    EXPECT_NE(refusal.find(reason), std::string::npos) << refusal;
  }
}

#ifndef MULTUM_SHADOW_MEMORY  // sanitizers have no memory limit
TEST_F(MeshDecodingTest, MemoryIsLimited) {
  const std::string refusal = refusal_of(write("bomb.gltf", gltf_bomb()));
  EXPECT_NE(refusal.find(" 1073"), std::string::npos) << refusal;
  expect_says(refusal, {"bomb.gltf", "decoding", "bytes of memory"});
  EXPECT_EQ(refusal_of(write_grid("grid.obj", 2)), "") << "the next file is read";
}
#endif

// None of our decoders gives these answers.
TEST(MeshMessagesTest, AnswersAreChecked) {
  const AskedFile asked = {"a.obj", "assimp", 1000};
  const auto opened = [&](std::uint64_t position_count) {
    MessageWriter out;
    out.number(std::uint64_t{0});  // parts
    for (const std::uint64_t count : {position_count, position_count, position_count, position_count})
      out.number(count);
    const std::string bytes = out.number(std::uint64_t{3}).take();
    MessageReader in(bytes);
    return parse_mesh_answer<TriangleMesh>(asked, in);
  };
  for (const std::uint64_t count : {std::uint64_t{100}, std::numeric_limits<std::uint64_t>::max()})
    expect_error(ErrorCode::kInput, {"a.obj: damaged", "at most 1000 bytes"}, [&] { opened(count); });
  TriangleMesh triangle = opened(3);
  std::vector<std::byte> memory(array_bytes(triangle));
  take_arrays(asked, memory.data(), triangle);
  const auto refused = [&](const TriangleMesh& wrong) {
    TriangleMesh mesh = wrong;
    expect_error(ErrorCode::kInput, {"a.obj: damaged", "valid mesh"}, [&] { take_arrays(asked, memory.data(), mesh); });
  };
  TriangleMesh wrong = triangle;
  wrong.parts = {{"", 0, 2, 0xffffffff}};
  refused(wrong);
  wrong = triangle;
  wrong.uvs.pop_back();
  refused(wrong);
  memory.back() = std::byte{1};  // the last index
  refused(triangle);
  memory.assign(memory.size(), std::byte{0});
  memory[2] = std::byte{0x80}, memory[3] = std::byte{0x7f};  // infinity
  refused(triangle);
}

// Damaged meshes are read or refused within the time limit.
TEST_F(MeshDecodingTest, DamagedFilesOfTheSharedData) {
  const std::string data = shared_data();
  if (data.empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder of damaged files";
  int count = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(data + "/bad/mesh")) {
    if (!entry.is_regular_file()) continue;
    const std::string refusal = refusal_of(entry.path().string());
    std::printf("%-40.40s %s\n", entry.path().filename().c_str(),
                refusal.empty() ? "read" : refusal.c_str() + entry.path().string().size());
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace multum::testing
