// SPDX-License-Identifier: Apache-2.0
// Tests multum-view as texture inference uses it. `probe` writes measured matrices to files, and `sample` draws the
// textures that a manifest names. The matrix A that `probe` writes, times the texture x, must equal the picture that
// `sample` draws.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <filesystem>
#include <numeric>
#include <sstream>

#include <nlohmann/json.hpp>

#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/inferred/probe_request.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/processes/child_process.h"
#include "tests/gl/probe_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;
using Names = std::set<std::string>;

constexpr int kWidth = 96, kHeight = 72, kSupersampling = 2;

void append_obj(const std::string& name, const gl::MeshData& data, std::size_t& vertex_count, std::ostream& out) {
  out.precision(9);
  out << "o " << name << "\n";
  for (const gl::MeshVertex& v : data.vertices)
    out << "v " << v.position.x << " " << v.position.y << " " << v.position.z << "\nvt " << v.uv.x << " " << v.uv.y
        << "\n";
  for (std::size_t i = 0; i < data.indices.size(); i += 3) {
    out << "f";
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t number = vertex_count + data.indices[i + k] + 1;
      out << " " << number << "/" << number;
    }
    out << "\n";
  }
  vertex_count += data.vertices.size();
}

// Makes the waves, which are partly behind a board.
std::string scene_obj() {
  gl::MeshData board = gl::board_mesh();
  const glm::vec2 corners[] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
  for (std::size_t i = 0; i < 4; ++i) board.vertices[i].uv = corners[i];
  std::ostringstream out;
  std::size_t vertex_count = 0;
  append_obj("waves", gl::wave_mesh(1.0f), vertex_count, out);
  append_obj("board", board, vertex_count, out);
  return out.str();
}

// If the board has moved, the waves have different texture coordinates, as in another block of the parameter space.
TextureMapping mapping_of(const std::string& object, const std::string& view = "still") {
  TextureMapping mapping;
  if (object == "waves") {  // the mapping is rotated and smaller than the texture, and the sides are not powers of two
    mapping.linear = glm::dmat2(0.0, 0.875, 0.75, 0.0);
    mapping.offset = {0.125, 0.0625};
    mapping.width = 77;
    mapping.height = 41;
    if (view == "moved") mapping.linear *= 0.75;
    if (view == "moved") mapping.width = 50;
  } else {  // this mapping extends beyond the border on all sides
    mapping.linear = glm::dmat2(2.5, 0.0, 0.0, 2.5);
    mapping.wrap_s = WrapMode::kPeriodic;
    mapping.width = 32;
    mapping.height = 16;
  }
  return mapping;
}

glm::dmat4 moved_board() { return glm::translate(glm::dmat4(1.0), glm::dvec3(0.55, 0.05, -0.1)); }

ChildResult run_view(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum-view");
  arguments.insert(arguments.end(), {"--context", "osmesa"});
  return run_child(arguments);
}

// Makes a folder that holds the scene.
class InferredViewTest : public ::testing::Test {
 protected:
  InferredViewTest() { write_bytes(path("scene.obj"), scene_obj()); }
  std::string path(const std::string& name) const { return folder_ / name; }

  ProbeRequest request(const std::string& view) const {
    ProbeRequest request;
    request.geometry_file = path("scene.obj");
    request.width = kWidth;
    request.height = kHeight;
    request.supersampling = kSupersampling;
    request.view = view;
    request.world_to_clip = glm::dmat4(gl::probe_camera(kWidth, kHeight));
    if (view == "moved") request.object_to_world["board"] = moved_board();
    for (const char* object : {"waves", "board"})
      request.tasks.push_back({object, mapping_of(object, view), 1.0f, true, path(view + "_" + object + ".filter"),
                               std::string("key of ") + object});
    return request;
  }
  void probe(const std::string& view, const std::vector<std::string>& options = {}) {
    write_probe_request(request(view), path("request.json"));
    std::vector<std::string> arguments = {"probe", path("request.json")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ChildResult result = run_view(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.output;
    for (const char* object : {"waves: ", "board: "})
      EXPECT_NE(result.output.find(object), std::string::npos) << result.output;
  }
  FilterMatrix matrix(const std::string& view, const std::string& object) const {
    return read_filter_matrix(path(view + "_" + object + ".filter"));
  }
  /// Expects this exit code and message, and that no file was written, not even in part.
  void expect_refusal(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& parts) const {
    const Names before = folder_.names();
    const ChildResult result = run_view(arguments);
    EXPECT_EQ(result.exit_code, code) << result.output;
    testing::expect_says(result.output, parts);
    EXPECT_EQ(folder_.names(), before);
  }

  TemporaryFolder folder_;
};

// ---- probe

std::vector<float> coverage_of(const FilterMatrix& matrix) {
  std::vector<float> coverage(kWidth * kHeight, 0.0f);
  for (std::size_t r = 0; r < matrix.row_count(); ++r) coverage[matrix.pixels[r]] = matrix.coverage[r];
  return coverage;
}

TEST_F(InferredViewTest, ProbesMatricesIntoFiles) {
  probe("still");
  EXPECT_EQ(folder_.names(), (Names{"request.json", "scene.obj", "still_board.filter", "still_waves.filter"}));
  for (const std::string object : {"waves", "board"}) {
    SCOPED_TRACE(object);
    const FilterMatrix m = matrix("still", object);
    const TextureMapping mapping = mapping_of(object);
    EXPECT_EQ(m.width, kWidth);
    EXPECT_EQ(m.height, kHeight);
    EXPECT_EQ(m.supersampling, kSupersampling);
    EXPECT_EQ(m.texture_width, mapping.width);
    EXPECT_EQ(m.texture_height, mapping.height);
    EXPECT_EQ(m.wrap_s, mapping.wrap_s);
    EXPECT_EQ(m.wrap_t, mapping.wrap_t);
    EXPECT_EQ(m.anisotropy, 1.0f);
    EXPECT_TRUE(m.has_mips);
    EXPECT_EQ(m.provenance.software.rfind("multum-view ", 0), 0u) << m.provenance.software;
    EXPECT_EQ(m.provenance.renderer.rfind("osmesa: ", 0), 0u) << m.provenance.renderer;
    EXPECT_EQ(m.provenance.view, "still");
    EXPECT_EQ(m.provenance.object, object);
    EXPECT_EQ(m.provenance.mesh_hash.size(), 64u);
    EXPECT_EQ(m.provenance.view_matrix.size(), 64u);
    EXPECT_EQ(m.provenance.key, "key of " + m.provenance.object);
    EXPECT_GT(m.row_count(), 300u);
    EXPECT_LE(m.rows_rejected, m.row_count() / 1000);
    for (std::size_t r = 0; r < m.row_count(); ++r) {
      const double sum =
          std::accumulate(m.weights.begin() + m.row_begin[r], m.weights.begin() + m.row_begin[r + 1], 0.0);
      ASSERT_NEAR(sum, 1.0, 1e-4) << "row " << r;
      ASSERT_TRUE(r == 0 || m.pixels[r - 1] < m.pixels[r]) << "row " << r;
      for (std::uint32_t i = m.row_begin[r] + 1; i < m.row_begin[r + 1]; ++i)
        ASSERT_LT(m.columns[i - 1], m.columns[i]) << "row " << r;
      const float quarters = 4.0f * m.coverage[r];
      ASSERT_EQ(quarters, std::round(quarters)) << "2 x 2 sub-pixels";
    }
  }
  EXPECT_NE(matrix("still", "waves").provenance.mesh_hash, matrix("still", "board").provenance.mesh_hash);
  EXPECT_EQ(matrix("still", "waves").provenance.view_matrix, matrix("still", "board").provenance.view_matrix);
}

TEST_F(InferredViewTest, WhatTheBoardHidesHasNoRows) {
  probe("still");
  probe("moved");
  const std::vector<float> waves = coverage_of(matrix("still", "waves")), board = coverage_of(matrix("still", "board"));
  const std::vector<float> waves_then = coverage_of(matrix("moved", "waves"));
  const std::vector<float> board_then = coverage_of(matrix("moved", "board"));
  int hidden = 0, shared = 0, uncovered = 0;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    EXPECT_LE(waves[i] + board[i], 1.0f) << "a sub-pixel shows one object";
    if (board[i] == 1.0f) {
      EXPECT_EQ(waves[i], 0.0f);
      hidden += waves_then[i] > 0.0f;
    }
    shared += waves[i] > 0.0f && board[i] > 0.0f;
    uncovered += board[i] == 1.0f && board_then[i] == 0.0f;
  }
  EXPECT_GT(hidden, 50) << "pixels of the board that show waves after the board has moved";
  EXPECT_GT(shared, 10) << "pixels of both";
  EXPECT_GT(uncovered, 50);
  EXPECT_NE(matrix("still", "waves").provenance.view_matrix, matrix("moved", "waves").provenance.view_matrix);
  EXPECT_EQ(matrix("still", "board").provenance.mesh_hash, matrix("moved", "board").provenance.mesh_hash);
}

TEST_F(InferredViewTest, TheSameRequestGivesTheSameBytes) {
  probe("still", {"--threads", "1"});
  const std::string before = read_bytes(path("still_waves.filter"));
  probe("still", {"--threads", "3", "--matrix-market"});
  EXPECT_EQ(read_bytes(path("still_waves.filter")), before);
  const FilterMatrix waves = matrix("still", "waves");
  std::istringstream text(read_bytes(path("still_waves.filter.mtx")));
  std::string line;
  while (text.peek() == '%') std::getline(text, line);
  std::size_t rows = 0, columns = 0, entries = 0;
  text >> rows >> columns >> entries;
  EXPECT_EQ(rows, waves.row_count());
  EXPECT_EQ(columns, static_cast<std::size_t>(waves.layout().texel_count));
  EXPECT_EQ(entries, waves.columns.size());
  EXPECT_TRUE(folder_.names().count("still_board.filter.mtx"));
}

TEST_F(InferredViewTest, RequestsThatCannotBeMetLeaveNothing) {
  const std::string file = path("request.json");
  const auto refuse = [&](const std::function<void(ProbeRequest&)>& change, int code,
                          const std::vector<std::string>& parts) {
    ProbeRequest changed = request("still");
    change(changed);
    write_probe_request(changed, file);
    expect_refusal({"probe", file}, code, parts);
  };
  refuse([](ProbeRequest& r) { r.tasks[1].object = "cup"; }, 3, {"scene.obj: ", "no object", "'cup'", "waves, board"});
  refuse([&](ProbeRequest& r) { r.geometry_file = path("none.obj"); }, 3, {"none.obj"});
  refuse([](ProbeRequest& r) { r.uv_set = 1; }, 3, {"no texture coordinates", "set 1"});
  refuse([](ProbeRequest& r) { r.supersampling = 9; }, 3, {"request.json: ", "96 x 72", "supersampling 9"});
  refuse([](ProbeRequest& r) { r.tasks[1].output = r.tasks[0].output; }, 2, {"twice"});
  refuse([](ProbeRequest& r) { r.tasks[1].output = r.geometry_file; }, 2, {"scene.obj: ", "twice"});
  refuse([&](ProbeRequest& r) { r.tasks[1].output = file; }, 2, {"request.json: ", "twice"});
  refuse([&](ProbeRequest& r) { r.tasks[1].output = path("none/a.filter"); }, 4, {"none", "not exist"});
  EXPECT_EQ(read_bytes(path("scene.obj")), scene_obj());
  const std::string whole = read_bytes(file);
  write_bytes(file, whole.substr(0, whole.size() / 2));
  expect_refusal({"probe", file}, 3, {"request.json: ", "not a probe request"});
  expect_refusal({"probe", path("none.json")}, 3, {"none.json: ", "read"});
  expect_refusal({"probe", file, "more"}, 2, {"not expected", "more"});
  expect_refusal({"probe", file, "--threads", "0"}, 2, {"--threads"});
}

// ---- sample

// Random 16-bit floats.
InferredTexture random_texture(const TextureMapping& mapping, std::uint64_t seed) {
  InferredTexture texture{mapping.width, mapping.height, {}, "{}"};
  SplitMix64 random(seed);
  for (int i = 0; i < 3 * MipLayout(mapping.width, mapping.height).texel_count; ++i)
    texture.texels.push_back(static_cast<float>(half(static_cast<float>(0.5 * random.uniform()))));
  return texture;
}

struct Floats {
  int width = 0, height = 0, channels = 0;
  std::vector<float> values;
  std::string colour_space;
};

Floats read_floats(const std::string& path) {
  const auto file = OIIO::ImageInput::open(path);
  if (file == nullptr) {
    ADD_FAILURE() << path << ": " << OIIO::geterror();
    return {};
  }
  const OIIO::ImageSpec& spec = file->spec();
  Floats floats{spec.width, spec.height, spec.nchannels, {}, spec.get_string_attribute("oiio:ColorSpace").c_str()};
  floats.values.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
  EXPECT_TRUE(file->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, floats.values.data()));
  return floats;
}

// There are two samples. The board has moved in the second sample. The waves have two layers in the first sample. The
// board has no texture in the second sample.
class InferredPictureTest : public InferredViewTest {
 protected:
  void SetUp() override {
    std::uint64_t seed = 77;
    for (const char* name : {"waves_0", "waves_1", "waves_shine_0", "board_0"}) {
      const std::string object = std::string(name).substr(0, 5);
      textures_[name] = random_texture(mapping_of(object, name == std::string("waves_1") ? "moved" : "still"), seed++);
      write_inferred_texture(textures_[name], path(name + std::string(".exr")));
    }
    manifest_.geometry_file = "scene.obj";
    manifest_.geometry_hash = hash_file(path("scene.obj"));
    manifest_.width = kWidth;
    manifest_.height = kHeight;
    manifest_.supersampling = kSupersampling;
    manifest_.parameters = {"view", "motion"};
    const glm::dmat4 camera(gl::probe_camera(kWidth, kHeight));
    manifest_.samples = {{"still", {2, 0}, camera, {}}, {"moved", {2, 1}, camera, {{"board", moved_board()}}}};
    manifest_.objects = {
        {"the waves",
         "waves",
         {mapping_of("waves", "moved"), mapping_of("waves")},
         {1, 0},
         1.0f,
         {{"diffuse", {"waves_0.exr", "waves_1.exr"}}, {"shine", {"waves_shine_0.exr", ""}}}},
        {"the board", "board", {mapping_of("board")}, {0, 0}, 1.0f, {{"diffuse", {"board_0.exr", ""}}}}};
    write_inferred_manifest(manifest_, path("inferred.json"));
  }
  ChildResult draw(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"sample", folder_.path()});
    return run_view(arguments);
  }
  /// Adds A x of an object, weighted by the object's coverage, and adds the coverage.
  void add(const std::string& view, const std::string& object, const std::vector<std::string>& layers,
           std::vector<double>& rgba) const {
    const FilterMatrix m = matrix(view, object);
    EXPECT_EQ(m.rows_rejected, 0u);
    for (std::size_t r = 0; r < m.row_count(); ++r) {
      double* pixel = &rgba[4u * m.pixels[r]];
      const double coverage = static_cast<double>(m.coverage[r]);
      pixel[3] += coverage;
      for (std::uint32_t i = m.row_begin[r]; i < m.row_begin[r + 1]; ++i)
        for (const std::string& layer : layers)
          for (std::size_t c = 0; c < 3; ++c)
            pixel[c] += coverage * static_cast<double>(m.weights[i]) *
                        static_cast<double>(textures_.at(layer).texels[3u * m.columns[i] + c]);
    }
  }
  void expect_picture(const std::string& name, const std::vector<double>& rgba) const {
    SCOPED_TRACE(name);
    const Floats picture = read_floats(path(name));
    ASSERT_EQ(picture.width, kWidth);
    ASSERT_EQ(picture.height, kHeight);
    ASSERT_EQ(picture.channels, 4);
    double worst = 0.0;
    for (std::size_t i = 0; i < rgba.size(); ++i) {
      const double found = static_cast<double>(picture.values[i]);
      worst = std::max(worst, std::abs(found - rgba[i]));
      ASSERT_TRUE(i % 4 != 3 || found == rgba[i]) << "coverage, in quarters, of pixel " << i / 4;
    }
    EXPECT_LE(worst, 1e-5);
    RecordProperty("worst_" + name, std::to_string(worst));
  }
  std::map<std::string, InferredTexture> textures_;
  InferredManifest manifest_;
};

TEST_F(InferredPictureTest, PicturesAreMatrixTimesTexture) {
  probe("still");
  probe("moved");
  std::vector<double> still(4 * kWidth * kHeight), moved = still;
  add("still", "waves", {"waves_0", "waves_shine_0"}, still);
  add("still", "board", {"board_0"}, still);
  add("moved", "waves", {"waves_1"}, moved);
  add("moved", "board", {}, moved);  // the board is black and hides the waves behind it
  const ChildResult result = draw({"--at", "2,0", "-o", path("still.exr"), "--at", "2,1", "-o", path("moved.exr"),
                                   "--at", "still", "-o", path("again.exr")});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  expect_picture("still.exr", still);
  expect_picture("moved.exr", moved);
  expect_picture("again.exr", still);
  EXPECT_EQ(read_floats(path("again.exr")).values, read_floats(path("still.exr")).values) << "what was drawn between";
}

// Encodes a linear value to 8 bits (IEC 61966-2-1).
int srgb_code(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return static_cast<int>(std::lround(255.0 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1.0 / 2.4) - 0.055)));
}

TEST_F(InferredPictureTest, PngsAreSrgbOfTheSamePicture) {
  ASSERT_EQ(draw({"--at", "2,0", "-o", path("a.png"), "--at", "2,0", "-o", path("a.exr")}).exit_code, 0);
  ASSERT_EQ(draw({"--at", "2,0", "-o", path("b.png"), "--exposure", "2.5"}).exit_code, 0);
  const Floats linear = read_floats(path("a.exr"));
  for (const auto& [name, exposure] : {std::pair{"a.png", 1.0f}, std::pair{"b.png", 2.5f}}) {
    SCOPED_TRACE(name);
    const Floats png = read_floats(path(name));
    EXPECT_EQ(png.colour_space, "sRGB");
    ASSERT_EQ(png.channels, 3);
    ASSERT_EQ(png.values.size(), 3u * kWidth * kHeight);
    int clipped = 0;
    for (std::size_t i = 0; i < png.values.size(); ++i) {
      const int expected = srgb_code(static_cast<double>(exposure * linear.values[i / 3 * 4 + i % 3]));
      ASSERT_EQ(std::lround(255.0f * png.values[i]), expected) << i;
      clipped += expected == 255;
    }
    EXPECT_EQ(clipped > 0, exposure > 2.0f);
  }
}

TEST_F(InferredPictureTest, TheThumbnailIsTheFirstSample) {
  ASSERT_EQ(draw({"--at", "still", "-o", path("still.png")}).exit_code, 0);
  std::filesystem::create_directory(path("small"));
  const ChildResult result = run_view({"thumbnails", folder_.path(), "-o", path("small")});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(read_floats(path("small/render.png")).values, read_floats(path("still.png")).values);
  EXPECT_FALSE(std::filesystem::exists(path("small/frame.png")));
}

TEST_F(InferredPictureTest, TheFolderMayBeNamedLastAndByItsManifest) {
  const ChildResult last = run_view({"sample", "--at", "still", "-o", path("a.exr"), folder_.path() + "/"});
  EXPECT_EQ(last.exit_code, 0) << last.output;
  const ChildResult manifest = run_view({"sample", path("inferred.json"), "--at=2,0", "-o", path("b.exr")});
  EXPECT_EQ(manifest.exit_code, 0) << manifest.output;
  EXPECT_EQ(read_floats(path("a.exr")).values, read_floats(path("b.exr")).values);
}

TEST_F(InferredPictureTest, WrongCommandLinesAreUsageErrors) {
  const auto refuse = [&](std::vector<std::string> arguments, const std::vector<std::string>& parts) {
    SCOPED_TRACE(parts.front());
    arguments.insert(arguments.begin(), {"sample", folder_.path()});
    expect_refusal(arguments, 2, parts);
  };
  const std::string a = path("a.exr");
  for (const char* sample : {"9,9", "2", "2,0,0", "2, 0", "", "STILL"})
    refuse({"--at", sample, "-o", a}, {"view,motion", "2,0 to 2,1", "name", "still"});
  refuse({"--at", "2,0", "-o", a, "--at", "7,7", "-o", path("b.exr")}, {"sample", "'7,7'"});
  refuse({"--at", "2,0", "--at", "2,1", "-o", a}, {"2 samples", "1 --output"});
  refuse({"--at", "2,0", "-o", a, "-o", path("b.exr")}, {"1 samples", "2 --output"});
  refuse({"--at", "2,0"}, {"--output", "required"});
  refuse({"--at", "2,0", "-o", path("a.jpg")}, {"a.jpg", ".png or .exr"});
  refuse({"--at", "2,0", "-o", a, "--at", "2,1", "-o", path("./a.exr")}, {"a.exr", "twice"});
  refuse({"--at", "2,0", "-o", a, "--exposure", "0"}, {"--exposure"});
  // Tests files of textures, including those that the command never reads.
  const std::string before = read_bytes(path("waves_1.exr"));
  for (const char* texture : {"waves_0.exr", "waves_1.exr"})
    refuse({"--at", "2,0", "-o", path(texture)}, {texture, "is an input"});
  EXPECT_EQ(read_bytes(path("waves_1.exr")), before);
}

TEST_F(InferredPictureTest, FilesThatAreNotAsTheManifestSaysAreInputErrors) {
  const auto refuse = [&](const std::vector<std::string>& parts) {
    SCOPED_TRACE(parts.front());
    expect_refusal({"sample", folder_.path(), "--at", "2,0", "-o", path("a.exr")}, 3, parts);
  };
  const auto with_bytes = [&](const std::string& name, const std::string& bytes,
                              const std::vector<std::string>& parts) {
    const std::string before = read_bytes(path(name));
    write_bytes(path(name), bytes);
    refuse(parts);
    write_bytes(path(name), before);
  };
  const auto with_manifest = [&](const std::function<void(InferredManifest&)>& change,
                                 const std::vector<std::string>& parts) {
    InferredManifest changed = manifest_;
    change(changed);
    write_inferred_manifest(changed, path("inferred.json"));
    refuse(parts);
    write_inferred_manifest(manifest_, path("inferred.json"));
  };
  with_bytes("scene.obj", scene_obj() + "# changed\n", {"scene.obj: ", "not the geometry"});
  with_bytes("waves_shine_0.exr", read_bytes(path("board_0.exr")),
             {"waves_shine_0.exr: ", "32 x 16", "manifest", "77 x 41"});
  const std::string texture = read_bytes(path("board_0.exr")), text = read_bytes(path("inferred.json"));
  with_bytes("board_0.exr", texture.substr(0, texture.size() / 2), {"board_0.exr: ", "tiled EXR"});
  with_bytes("inferred.json", text.substr(0, text.size() - 3), {"inferred.json: ", "not a manifest"});
  with_bytes("inferred.json", "{}", {"'multumInferredTextures'", "not found"});
  with_manifest([](InferredManifest& m) { m.objects[1].mesh = "cup"; }, {"no object", "'cup'", "waves, board"});
  with_manifest([](InferredManifest& m) { m.geometry_file = "none.obj"; }, {"none.obj: ", "cannot be read"});
  with_manifest([](InferredManifest& m) { m.samples.clear(), m.objects.clear(); }, {"inferred.json: ", "no samples"});
  expect_refusal({"sample", path("none"), "--at", "2,0", "-o", path("a.exr")}, 3, {"none/inferred.json: ", "read"});
  std::filesystem::remove(path("waves_0.exr"));
  refuse({"waves_0.exr: ", "tiled EXR"});
  expect_refusal({"sample", folder_.path(), "--at", "2,0", "-o", "/proc/none/a.exr"}, 4, {"/proc/none", "folder"});
}

// Pictures drawn before the error are complete; the others leave no partial file.
TEST_F(InferredPictureTest, PicturesBeforeTheTroubleAreWhole) {
  std::filesystem::remove(path("waves_1.exr"));
  Names names = folder_.names();
  const ChildResult result = draw({"--at", "2,0", "-o", path("a.exr"), "--at", "2,1", "-o", path("b.exr")});
  EXPECT_EQ(result.exit_code, 3) << result.output;
  EXPECT_NE(result.output.find("waves_1.exr"), std::string::npos) << result.output;
  names.insert("a.exr");
  EXPECT_EQ(folder_.names(), names);
  EXPECT_EQ(read_floats(path("a.exr")).width, kWidth);
}

}  // namespace
}  // namespace multum
