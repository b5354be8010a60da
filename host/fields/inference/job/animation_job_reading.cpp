// SPDX-License-Identifier: Apache-2.0
// Reads the parts of a job in this order, because later parts refer to earlier parts: parameters, layers, objects of
// the geometry file, cameras, samples. Each error message can name the line of a wrong reference.
// host/fields/inference/job/animation_samples reads the samples.
#include "host/fields/inference/job/animation_job_reading.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/matrix.hpp>

#include "host/fields/inference/job/animation_samples.h"
#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

constexpr int kSampleCountMax = 65536;  // each sample has one or two files
// This limit is enough for this many samples. Each sample with its own camera has 68 keys and values, which take 1.2 KB
// in total.
const TomlLimits kTomlLimits = {.byte_max = std::size_t{80} << 20, .item_max = 5'000'000};

const std::vector<std::string> kJobKeys = {
    "geometry",     "uv_set",       "width",   "height",    "cryptomatte", "depth",  "depth_tolerance", "supersampling",
    "radiance_max", "coverage_min", "texture", "parameter", "layer",       "object", "camera",          "sample"};
const std::vector<std::string> kTextureKeys = {"wrap",     "stretch_max", "resolution_scale", "power_of_two",
                                               "side_max", "anisotropy",  "pyramid_weight",   "range_weight"};

// Names are used as the names of folders and files.
std::string checked_name(const StrictTable& table) {
  const std::string name = table.text("name");
  const bool has_bad_letter = std::any_of(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < 32 || c == '/' || c == '\\'; });
  if (has_bad_letter || name.front() == '.' || name.size() > 100)
    table.refuse(
        "name",
        fmt::format("is \"{}\", expected up to 100 characters without / and \\ and without a dot at the beginning",
                    name));
  return name;
}

template <typename Item>
void add_unique(std::vector<Item>& items, Item item, const StrictTable& table) {
  for (const Item& other : items)
    if (other.name == item.name)
      table.refuse("name", fmt::format("is \"{}\", which is already in use; expected a unique name", item.name));
  items.push_back(std::move(item));
}

void read_settings(const StrictTable& job_table, AnimationJob& job) {
  job.uv_set = job_table.whole("uv_set", 0, 7, job.uv_set);
  job.width = job_table.whole("width", 1, kGpuSideMax);
  job.height = job_table.whole("height", 1, kGpuSideMax);
  job.cryptomatte = job_table.text("cryptomatte", job.cryptomatte);
  job.depth = job_table.text("depth", job.depth);
  job.depth_tolerance = job_table.number("depth_tolerance", kAboveZero, job.depth_tolerance);
  job.supersampling = job_table.whole("supersampling", 1, 8, job.supersampling);
  job.radiance_max = job_table.number("radiance_max", kAboveZero, job.radiance_max);
  job.coverage_min =
      job_table.number("coverage_min", {0.0, 1.0, false, true, "a number from 0 to below 1"}, job.coverage_min);
}

AnimationTexture read_texture(const StrictTable& table, const AnimationTexture& fallback) {
  AnimationTexture texture = fallback;
  texture.wrap = table.text("wrap", fallback.wrap);
  if (texture.wrap != "clamp" && texture.wrap != "periodic")
    table.refuse("wrap", fmt::format("is \"{}\", expected \"clamp\" or \"periodic\"", texture.wrap));
  texture.stretch_max = table.number("stretch_max", kAboveZero, fallback.stretch_max);
  texture.resolution_scale =
      table.number("resolution_scale", {0.0, 8.0, true, false, "a number above 0, up to 8"}, fallback.resolution_scale);
  texture.power_of_two = table.boolean("power_of_two", fallback.power_of_two);
  texture.side_max = table.whole("side_max", 1, kGpuSideMax, fallback.side_max);
  texture.anisotropy =
      table.number("anisotropy", {1.0, 16.0, false, false, "a number from 1 to 16"}, fallback.anisotropy);
  texture.pyramid_weight = table.number("pyramid_weight", kFromZero, fallback.pyramid_weight);
  texture.range_weight = table.number("range_weight", kFromZero, fallback.range_weight);
  return texture;
}

void read_parameters(const StrictTable& job_table, AnimationJob& job) {
  int sample_count = 1;
  for (const toml::table* entry : job_table.tables("parameter")) {
    const StrictTable table(job.path, *entry, "parameter", {"name", "count", "view", "block"});
    AnimationParameter parameter;
    parameter.name = checked_name(table);
    parameter.count = table.whole("count", 1, kSampleCountMax);
    parameter.is_view = table.boolean("view", false);
    parameter.block = table.whole("block", 0, kSampleCountMax, 0);
    if (parameter.count > kSampleCountMax / sample_count)
      table.refuse("count",
                   fmt::format("is {}, expected at most {} samples in total", parameter.count, kSampleCountMax));
    sample_count *= parameter.count;
    add_unique(job.parameters, parameter, table);
  }
}

void read_layers(const StrictTable& job_table, AnimationJob& job) {
  const std::vector<std::string> parameters = names_of(job.parameters);
  std::set<std::string> passes;
  for (const toml::table* entry : job_table.tables("layer")) {
    const StrictTable table(job.path, *entry, "layer", {"name", "passes", "depends_on"});
    AnimationLayer layer;
    layer.name = checked_name(table);
    layer.passes = table.texts("passes", true);
    if (layer.passes.empty()) table.refuse("passes", "is empty, expected at least one pass");
    for (const std::string& pass : layer.passes)
      if (!passes.insert(pass).second)
        table.refuse("passes",
                     fmt::format("names \"{}\" twice; layers are added, so this pass would be added twice", pass));
    layer.depends_on = table.texts("depends_on", true);
    for (const std::string& name : layer.depends_on) check_known(table, "depends_on", name, parameters, "parameter");
    if (std::set<std::string>(layer.depends_on.begin(), layer.depends_on.end()).size() != layer.depends_on.size())
      table.refuse("depends_on", "names a parameter twice");
    add_unique(job.layers, layer, table);
  }
}

void read_objects(const StrictTable& job_table, const std::vector<std::string>& meshes, AnimationJob& job) {
  const StrictTable defaults_table(job.path, job_table.table("texture"), "texture", kTextureKeys);
  const AnimationTexture defaults = read_texture(defaults_table, {});
  std::set<int> indices;
  for (const toml::table* entry : job_table.tables("object")) {
    const StrictTable table(job.path, *entry, "object", {"name", "mesh", "cryptomatte", "index", "layers", "texture"});
    AnimationObject object;
    object.name = checked_name(table);
    object.mesh = table.text("mesh", object.name);
    check_known(table, "mesh", object.mesh, meshes, "object of the geometry file");
    object.cryptomatte = table.text("cryptomatte", "");
    object.index = table.whole("index", 0, 65535, 0);
    if (object.index > 0 && !indices.insert(object.index).second)
      table.refuse("index", fmt::format("is {}, which another object already has", object.index));
    if (object.index == 0 && object.cryptomatte.empty())
      table.refuse("", "has neither cryptomatte nor index, so its pixels cannot be identified; add one of them");
    object.layers = table.texts("layers", false);
    for (const std::string& name : object.layers) check_known(table, "layers", name, names_of(job.layers), "layer");
    const StrictTable texture_table(job.path, table.table("texture"), "object.texture", kTextureKeys);
    object.texture = read_texture(texture_table, defaults);
    add_unique(job.objects, object, table);
  }
}

// Depth is measured along -z, and the frustum is cut at planes of constant z. Therefore w must be -z (up to a factor),
// and x and y must grow to the right and upwards.
void check_camera(const StrictTable& table, const AnimationCamera& camera) {
  const glm::dmat4& m = camera.world_to_camera;
  if (m[0][3] != 0.0 || m[1][3] != 0.0 || m[2][3] != 0.0 || m[3][3] != 1.0)
    table.refuse(
        "world_to_camera",
        "has a last row that is not 0 0 0 1; expected the four rows of a matrix that multiplies column vectors");
  if (!(glm::determinant(glm::dmat3(m)) > 0.0))
    table.refuse("world_to_camera", "is mirrored or flat, because its determinant is not above 0");
  const glm::dmat4& p = camera.projection;
  const bool has_w = p[0][3] == 0.0 && p[1][3] == 0.0 && p[2][3] < 0.0 && p[3][3] == 0.0;
  if (!has_w || !(p[0][0] > 0.0) || !(p[1][1] > 0.0) || p[3][0] != 0.0 || p[3][1] != 0.0)
    table.refuse("projection",
                 "is not a perspective projection: expected a last row of 0 0 -1 0, two numbers above 0 at the "
                 "beginning of the diagonal, and 0 0 at the beginning of the last column");
}

void read_cameras(const StrictTable& job_table, AnimationJob& job) {
  for (const toml::table* entry : job_table.tables("camera")) {
    const StrictTable table(job.path, *entry, "camera", {"name", "world_to_camera", "projection"});
    AnimationCamera camera;
    camera.name = table.text("name");
    camera.world_to_camera = table.matrix("world_to_camera");
    camera.projection = table.matrix("projection");
    check_camera(table, camera);
    add_unique(job.cameras, camera, table);
  }
}

// All renders of a folder must have the same passes. If a pass is missing in the first sample's files, the job is
// refused. If it is missing in another file, reading that file results in an error.
void check_passes(const StrictTable& job_table, const AnimationJob& job) {
  const AnimationSample& sample = job.samples.front();
  const std::vector<std::string> channels = exr_channel_names(sample.radiance);
  const auto layer_tables = job_table.tables("layer");
  for (std::size_t i = 0; i < job.layers.size(); ++i) {
    const StrictTable table(job.path, *layer_tables[i], "layer", {});
    for (const std::string& pass : job.layers[i].passes)
      for (const char* colour : {"R", "G", "B"})
        check_known(table, "passes", pass.empty() ? colour : pass + "." + colour, channels,
                    "channel of " + sample.radiance);
  }
}

void check_geometry_channels(const StrictTable& job_table, const AnimationJob& job) {
  const auto sample = std::find_if(job.samples.begin(), job.samples.end(),
                                   [](const AnimationSample& s) { return !s.geometry.empty(); });
  if (sample == job.samples.end()) return;
  if (!job.depth.empty())
    check_known(job_table, "depth", job.depth, exr_channel_names(sample->geometry), "channel of " + sample->geometry);
  if (!sample->object_index.empty()) return;
  std::vector<std::string> wanted;
  for (const AnimationObject& object : job.objects) wanted.push_back(object.cryptomatte);
  const CryptomatteNames names = find_cryptomatte_names(sample->geometry, job.cryptomatte, wanted);
  for (const std::string& warning : names.warnings) log_warning(sample->geometry, warning);
  const auto object_tables = job_table.tables("object");
  for (std::size_t i = 0; i < job.objects.size(); ++i) {
    const std::string& name = job.objects[i].cryptomatte;
    if (std::find(names.unseen.begin(), names.unseen.end(), name) == names.unseen.end()) continue;
    const StrictTable table(job.path, *object_tables[i], "object", {});
    if (!names.manifest.empty())
      check_known(table, "cryptomatte", name, names.manifest, "name in the manifest of " + sample->geometry);
    log_warning(sample->geometry, fmt::format("no pixel of Cryptomatte \"{}\" has the hash of \"{}\": the object is "
                                              "not visible there, or has another name",
                                              job.cryptomatte, name));
  }
}

}  // namespace

std::vector<std::string> animation_job_files(const std::string& path) {
  const toml::table root = parse_toml(path, "a job as described in docs/reference/animation_jobs.md", kTomlLimits);
  std::vector<std::string> files;
  std::set<std::string> known;
  const auto add = [&](const toml::table& table, const char* key) {
    const std::optional<std::string> name = table[key].value<std::string>();
    if (!name) return;
    const std::string file =
        (std::filesystem::path(path).parent_path() / path_of_text(*name)).lexically_normal().string();
    if (known.insert(file).second) files.push_back(file);
  };
  add(root, "geometry");
  if (const toml::array* samples = root["sample"].as_array())
    for (const toml::node& sample : *samples)
      if (const toml::table* table = sample.as_table())
        for (const char* key : {"radiance", "geometry", "object_index"}) add(*table, key);
  return files;
}

AnimationJob read_animation_job(const std::string& path) {
  const toml::table root = parse_toml(path, "a job as described in docs/reference/animation_jobs.md", kTomlLimits);
  AnimationJob job;
  job.path = path;
  const StrictTable table(job.path, root, "", kJobKeys);
  read_settings(table, job);
  job.geometry_file = existing_file(table, "geometry", job);
  const std::vector<std::string> meshes = names_of(read_object_meshes(job.geometry_file, job.uv_set));
  read_parameters(table, job);
  read_layers(table, job);
  read_objects(table, meshes, job);
  read_cameras(table, job);
  read_animation_samples(table, meshes, job);
  check_passes(table, job);
  check_geometry_channels(table, job);
  return job;
}

}  // namespace multum
