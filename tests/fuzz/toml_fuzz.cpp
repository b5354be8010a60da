// SPDX-License-Identifier: Apache-2.0
// Fuzzes readers of files that people write (manifests of bakes, jobs of texture inference, and scenes), and readers of
// files that a killed bake leaves. kReaders has a row for each reader.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "host/bakes/manifest/bake_manifest.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/scene/scene_file.h"
#include "host/fields/inference/job/animation_job_reading.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

void read_left_rows(const std::string& path) {
  const std::string folder = fuzz::scratch_folder() + "/.multum-partial-out.ndf.exr";
  std::filesystem::create_directory(folder);
  std::filesystem::copy_file(path, folder + "/progress", std::filesystem::copy_options::overwrite_existing);
  const auto rows = ResumedRows::open(nullptr, {}, fuzz::scratch_folder() + "/out.ndf.exr", "key", true, true);
  if (rows == nullptr) return;
  for (const int level : {1, 0}) {
    const LevelTask task = rows->begin({level, 8, 16, 0, level == 1, true});
    MULTUM_CHECK(task.rows_there >= 0 && task.rows_there <= 8);
    std::vector<unsigned char> bytes(std::size_t{16} * 8);
    rows->read(RowPart::kStored, 0, task.rows_there, bytes.data());
    rows->end();
  }
}

// Returns the records of three rows of level 1, as a killed bake would leave them.
std::string left_rows() {
  const std::string output = fuzz::scratch_folder() + "/seed.ndf.exr";
  const std::vector<unsigned char> bytes(std::size_t{16} * 8, 1);
  const auto rows = ResumedRows::open(nullptr, {}, output, "key", false, true);
  rows->begin({1, 8, 16, 0, true, true});
  rows->keep({0, 2, bytes.data(), nullptr, bytes.data()});
  rows->keep({2, 1, bytes.data(), nullptr, bytes.data()});
  std::ifstream file(partial_folder_of(output) + "/progress", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::vector<std::function<void(const std::string&)>> kReaders = {
    [](const std::string& path) { read_bake_manifest(path, BakeJob()); },
    [](const std::string& path) { read_animation_job(path); },
    read_left_rows,
    [](const std::string& path) { read_scene(path, BakeJob()); },
};

constexpr char kManifest[] = R"([defaults]
green = "up"
lobes = 4
error_max = 0.6
[[map]]
input = "bricks_normal.png"
output = "bricks.ndf.exr"
albedo = "bricks_<UDIM>.png"
wrap = "clamp"
lobes = 2
ndf = "vmf"
data_format = "half"
compression = "zip:4"
height_scale = 8.5
reference = false
)";

constexpr char kJob[] = R"(geometry = "scene.gltf"
width = 4
height = 3
[[parameter]]
name = "view"
count = 1
moves_camera = true
[[layer]]
name = "diffuse"
passes = ["diffuse"]
depends_on = ["view"]
[[object]]
name = "thing"
mesh = "thing"
cryptomatte = "thing"
[[camera]]
name = "v0"
projection = [[1,0,0,0],[0,1,0,0],[0,0,-1,-1],[0,0,-1,0]]
world_to_camera = [[1,0,0,0],[0,1,0,0],[0,0,1,-2],[0,0,0,1]]
[[sample]]
name = "v0"
at = [0]
camera = "v0"
radiance = "rad.exr"
geometry = "geom.exr"
)";

constexpr char kScene[] = R"([camera]
fov = 40
resolution = [1920, 1080]
[budget]
target_error = 0.2
bytes = 100000000
bake_ms = 5000
estimate_margin = 0.02
[[map]]
name = "bricks"
normal = "bricks_normal.png"
albedo = "bricks_albedo.png"
green = "up"
[[material]]
name = "glazed"
brdf = "ggx"
roughness = [0.2, 0.6]
f0 = [0.04, 0.05, 0.06]
[[material]]
name = "steel"
brdf = "blinn-phong"
exponent = 100
[[object]]
name = "wall"
map = "bricks"
material = "glazed"
width = 2.0
distance = [1.5, 40]
[[light]]
direction = [0.3, 0.8, 0.5]
[environment]
file = "sky.exr"
)";
// Contains structure that counts towards the limits (host/foundation/toml/toml_limits.h), and text that only looks like
// structure.
constexpr char kNested[] = R"([[a.b]]
c.d = [[1, {e.f = "x.[{", g = []}], '''y]'''] # h.i = [[
"j.k" = """m" "" \\"""
'n]' = {o = {p.q = 1979-05-27 07:32:00}}
)";
constexpr char kMeasured[] = "[[material]]\nname = \"metal\"\nbrdf = \"measured\"\nfile = \"metal.brdf\"\n";

}  // namespace

std::vector<std::string> fuzz::seeds() {
  std::string deep_key = "a", deep_array = "a = ";  // a key of 32,000 parts once crashed the program
  for (int i = 1; i < 32'000; ++i) deep_key += ".a";
  for (int i = 0; i < 300; ++i) deep_array += i % 2 == 0 ? "[" : "{b.c = ";
  return {std::string(1, '\0') + kManifest,
          std::string("\1") + kJob,
          "\2" + left_rows(),
          std::string("\3") + kScene,
          std::string("\3") + kScene + kMeasured,
          std::string("\3") + kNested,
          std::string(1, '\0') + deep_key + " = 1\n",
          std::string("\3") + deep_array};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, static_cast<unsigned>(kReaders.size()));
  const std::string path = fuzz::input_file("input.toml", input.bytes);
  fuzz::may_refuse([&] { kReaders[input.kind](path); });
  return 0;
}
