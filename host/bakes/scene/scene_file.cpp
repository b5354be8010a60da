// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>

#include "host/bakes/bake/job_parameters.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/formats/image/material_maps.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/brdf_families/brdf_forms.h"
#include "host/foundation/toml/parameter_keys.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kWholeFile[] = "the scene";
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const NumberRange kMetres = {1e-6, 1e9, false, false, "metres from 1e-6 to 1e9"};
const NumberRange kAny = {-kInfinity, kInfinity, true, true, "a number"};
const NumberRange kFromZeroToOne = {0.0, 1.0, false, false, "a number from 0 to 1"};
constexpr std::size_t kLightCountMax = 8;     // limit of multum-view for lights of each kind
constexpr std::size_t kMaterialCountMax = 4;  // largest number of basis BRDFs

// The names of things of one kind, which must be unique.
class Names {
 public:
  explicit Names(std::string kind) : kind_(std::move(kind)) {}

  std::string add(const StrictTable& table) {
    const std::string name = table.text("name");
    // Names become file names in the results folder.
    const bool is_plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
    });
    if (!is_plain || name.front() == '.')
      table.refuse("name", fmt::format("is \"{}\", expected letters, digits, _, - and .", name));
    if (find(name) < names_.size())
      table.refuse("name", fmt::format("is \"{}\", which is the name of another {}", name, kind_));
    names_.push_back(name);
    return name;
  }
  std::size_t index(const StrictTable& table, const std::string& key, const std::string& name) const {
    const std::size_t found = find(name);
    if (found < names_.size()) return found;
    const std::string nearest = nearest_name(name, names_);
    table.refuse(key, fmt::format("is \"{}\", which is not the name of a [[{}]]{}", name, kind_,
                                  nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest)));
  }

 private:
  std::size_t find(const std::string& name) const {
    return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), name) - names_.begin());
  }
  const std::string kind_;
  std::vector<std::string> names_;
};

// Checks that a file exists before any file is read.
void check_file(const StrictTable& table, const std::string& key, const std::string& file) {
  std::error_code error;
  if (file.empty() || fs::is_regular_file(file, error)) return;
  table.refuse(key,
               fmt::format("is {}, {}", file,
                           fs::is_directory(file, error) ? "a folder, expected a file" : "expected an existing file"));
}

StrictTable map_table(const std::string& path, const toml::table& toml) {
  std::vector<std::string> keys = bake_parameters().names(kInScene);
  keys.insert(keys.end(), {"name", "normal"});
  return {path, toml, "map", keys, kWholeFile};
}

SceneMap read_map(const std::string& path, const toml::table& toml, const BakeJob& pattern, Names& names,
                  bool reads_files) {
  const StrictTable table = map_table(path, toml);
  SceneMap map{names.add(table), pattern};
  ParameterValues values(bake_parameters());
  read_parameters(table, kInScene, values);
  apply(values, map.job);
  map.job.input = path_beside(path, table.path("normal"));
  for (std::string BakeJob::*file : kMaterialMaps) map.job.*file = path_beside(path, map.job.*file);
  if (!reads_files) return map;
  const auto file_of = [](const std::string& text) { return parse_channel_file(text).path; };
  check_file(table, "normal", map.job.input);
  check_file(table, "albedo", map.job.albedo);
  check_file(table, map.job.roughness_is_gloss ? "gloss" : "roughness", file_of(map.job.roughness));
  check_file(table, "weights", map.job.weights);
  return map;
}

// Lists the names that a material's `brdf` accepts.
struct NamedFamily {
  const BrdfFamily* family;
  bool width_in_map = false;
};

using NamedFamilies = std::vector<std::pair<std::string, NamedFamily>>;

const NamedFamilies& named_families() {
  static const NamedFamilies all = [] {
    NamedFamilies choices;
    for (const BrdfFamily& family : brdf_families()) choices.push_back({std::string(family.name), {&family}});
    choices.push_back({"roughness-map", {&brdf_family(BrdfKind::kBlinnPhong), true}});
    return choices;
  }();
  return all;
}

// Lists the members of all families, each once.
std::vector<std::string> member_keys() {
  std::vector<std::string> keys;
  for (const BrdfFamily& family : brdf_families())
    for (const BrdfMember& member : family.members)
      if (std::find(keys.begin(), keys.end(), member.key) == keys.end()) keys.emplace_back(member.key);
  return keys;
}

glm::vec3 read_colour(const StrictTable& table, const std::string& key, const NumberRange& range,
                      const glm::vec3& fallback) {
  const std::vector<double> n = table.numbers(key, range, 3);
  if (n.empty()) return fallback;
  if (n.size() == 2) table.refuse(key, "has 2 numbers, expected one, or three for red, green and blue");
  return n.size() == 1 ? glm::vec3(static_cast<float>(n[0])) : glm::vec3(n[0], n[1], n[2]);
}

// Reads a single width or both ends of a range.
std::vector<Brdf> with_widths(const StrictTable& table, const BrdfFamily& family, const Brdf& brdf) {
  const BrdfMember& width = family.members[0];
  const std::string key(width.key);
  const std::vector<double> ends = table.numbers(key, {width.low, width.high, false, false, range_text(width)}, 2);
  if (ends.empty()) table.refuse("", fmt::format("has no {}, which is required", key));
  if (ends.size() == 2 && !(ends[0] < ends[1]))
    table.refuse(key, fmt::format("is [{:g}, {:g}], expected the lower bound first", ends[0], ends[1]));
  std::vector<Brdf> brdfs;
  for (const double end : ends) {
    brdfs.push_back(brdf);
    width_of(family, brdfs.back()) = static_cast<float>(end);
  }
  return brdfs;
}

// Lists the families of BRDFs that have the member, as in "brdf = "cook-torrance" and "ggx"".
std::string families_with(const std::string& key) {
  std::vector<std::string> names;
  for (const BrdfFamily& family : brdf_families())
    for (const BrdfMember& member : family.members)
      if (member.key == key) names.push_back(fmt::format("\"{}\"", family.name));
  return fmt::format("brdf = {}", fmt::join(names, " and "));
}

void check_keys_of_family(const StrictTable& table, const NamedFamily& named, const std::string& name) {
  const std::span<const BrdfMember> members =
      named.width_in_map ? std::span<const BrdfMember>() : named.family->members;
  for (const std::string& key : member_keys()) {
    if (!table.has(key)) continue;
    if (std::any_of(members.begin(), members.end(), [&](const BrdfMember& member) { return member.key == key; }))
      continue;
    table.refuse(key, fmt::format("is for {}, found brdf = \"{}\"", families_with(key), name));
  }
  if (table.has("file") != named.family->is_file)
    table.refuse(table.has("file") ? "file" : "",
                 table.has("file") ? fmt::format("works only with brdf = \"measured\", found brdf = \"{}\"", name)
                                   : "has no file, which brdf = \"measured\" requires");
}

// If `reads_files` is true, reads the file of a measured BRDF, otherwise only its name.
SceneMaterial read_material(const std::string& path, const toml::table& toml, Names& names, bool reads_files) {
  std::vector<std::string> keys = member_keys();
  keys.insert(keys.end(), {"name", "brdf", "diffuse", "specular", "file"});
  const StrictTable table(path, toml, "material", keys, kWholeFile);
  SceneMaterial material;
  material.name = names.add(table);
  const std::string name = table.text("brdf");
  const std::optional<NamedFamily> named = table.choice("brdf", named_families());
  check_keys_of_family(table, *named, name);
  const BrdfFamily& family = *named->family;
  Brdf brdf;
  set_family(family, brdf);
  if (family.is_file) {
    material.measured_file = path_beside(path, table.path("file"));
    if (reads_files) check_file(table, "file", material.measured_file);
    if (reads_files) set_measured(material.measured_file, brdf);
  }
  brdf.f0 = read_colour(table, "f0", kFromZeroToOne, brdf.f0);
  brdf.diffuse = read_colour(table, "diffuse", kFromZero, brdf.diffuse);
  if (family.fit == BrdfFit::kNone && table.has("specular"))
    table.refuse("specular", fmt::format("works only with BRDFs that have a highlight, found brdf = \"{}\"", name));
  brdf.specular = read_colour(table, "specular", kFromZero, brdf.specular);
  material.width_in_map = named->width_in_map;
  const bool takes_width = family.has_width() && !named->width_in_map;
  material.brdfs = takes_width ? with_widths(table, family, brdf) : std::vector<Brdf>{brdf};
  return material;
}

std::vector<std::string> material_names(const StrictTable& table) {
  if (table.has("material") == table.has("materials"))
    table.refuse("", table.has("material") ? "has both material and materials, expected one of them"
                                           : "has no material, which is required");
  return table.has("material") ? std::vector<std::string>{table.text("material")} : table.texts("materials", true);
}

// Checks that the map holds the data that an object's materials need.
void check_materials(const StrictTable& table, const SceneObject& object, const SceneDescription& scene) {
  const SceneMap& map = scene.maps[object.map];
  const char* const key = table.has("material") ? "material" : "materials";
  if (object.materials.size() > kMaterialCountMax)
    table.refuse(key, fmt::format("has {} materials, expected at most {}", object.materials.size(), kMaterialCountMax));
  if (object.materials.size() > 1 && map.job.weights.empty())
    table.refuse(key,
                 fmt::format("has {} materials, but map \"{}\" has no weights", object.materials.size(), map.name));
  if (object.materials.empty()) table.refuse(key, "is an empty list, expected a material");
  for (const std::size_t m : object.materials) {
    const SceneMaterial& material = scene.materials[m];
    if (material.width_in_map && map.job.roughness.empty())
      table.refuse(key, fmt::format("is \"{}\", whose brdf is \"roughness-map\", but map \"{}\" has no roughness",
                                    material.name, map.name));
    if (!material.width_in_map && !map.job.roughness.empty())
      table.refuse(
          key,
          fmt::format("is \"{}\", but map \"{}\" has a roughness; expected a material with brdf = \"roughness-map\"",
                      material.name, map.name));
  }
}

SceneObject read_object(const std::string& path, const toml::table& toml, const SceneDescription& scene, Names& objects,
                        const Names& maps, const Names& materials) {
  const StrictTable table(path, toml, "object",
                          {"name", "map", "material", "materials", "texels_per_metre", "width", "distance", "tilt"},
                          kWholeFile);
  SceneObject object;
  object.name = objects.add(table);
  object.map = maps.index(table, "map", table.text("map"));
  const std::vector<std::string> names = material_names(table);
  for (const std::string& name : names)
    object.materials.push_back(materials.index(table, table.has("material") ? "material" : "materials", name));
  check_materials(table, object, scene);
  if (table.has("texels_per_metre") == table.has("width"))
    table.refuse("", table.has("width") ? "has both texels_per_metre and width, expected one of them"
                                        : "has neither texels_per_metre nor width, expected one of them");
  object.texels_per_metre =
      table.number("texels_per_metre", {1e-6, 1e9, false, false, "a number from 1e-6 to 1e9"}, 0.0);
  object.width = table.number("width", kMetres, 0.0);
  const std::vector<double> distance = table.numbers("distance", kMetres, 2);
  if (distance.empty()) table.refuse("", "has no distance, which is required");
  object.distance_min = distance.front();
  object.distance_max = distance.back();
  if (object.distance_max < object.distance_min)
    table.refuse("distance", fmt::format("is [{:g}, {:g}], expected the smaller distance first", object.distance_min,
                                         object.distance_max));
  object.tilt_max = table.number("tilt", {0.0, 89.9, false, false, "degrees from 0 to 89.9"}, object.tilt_max);
  return object;
}

SceneLight read_light(const std::string& path, const toml::table& toml) {
  const StrictTable table(path, toml, "light", {"direction", "irradiance", "position", "intensity"}, kWholeFile);
  SceneLight light;
  light.is_point = table.has("position");
  if (light.is_point == table.has("direction"))
    table.refuse("", light.is_point ? "has both direction and position, expected one of them"
                                    : "has neither direction nor position, expected one of them");
  const char *const place = light.is_point ? "position" : "direction", *const power =
                                                                           light.is_point ? "intensity" : "irradiance";
  for (const auto& [key, other] : {std::pair{"irradiance", "position"}, std::pair{"intensity", "direction"}})
    if (table.has(key) && table.has(other)) table.refuse(key, fmt::format("does not fit {}", other));
  const std::vector<double> p = table.numbers(place, kAny, 3);
  if (p.size() != 3) table.refuse(place, "does not have 3 numbers, expected x, y and z");
  light.place = {p[0], p[1], p[2]};
  if (!light.is_point && light.place == glm::dvec3(0.0)) table.refuse(place, "is 0, expected a direction");
  light.power = read_colour(table, power, kFromZero, glm::vec3(light.is_point ? 1.0f : 3.14159265f));
  if (!light.is_point && (light.power.y != light.power.x || light.power.z != light.power.x))
    table.refuse(power, "is a colour, expected one number, because distant lights are white");
  return light;
}

SceneCamera read_camera(const std::string& path, const toml::table& toml) {
  const StrictTable table(path, toml, "camera", {"fov", "resolution"}, kWholeFile);
  SceneCamera camera;
  camera.fov_degrees = table.number("fov", {1.0, 170.0, false, false, "degrees from 1 to 170"}, camera.fov_degrees);
  if (!table.has("resolution")) return camera;
  const std::vector<int> size = table.integers("resolution");
  if (size.size() != 2 || size[0] < 1 || size[1] < 1 || size[0] > 65536 || size[1] > 65536)
    table.refuse("resolution", "is not two integers from 1 to 65536, e.g. [1920, 1080]");
  camera.width = size[0];
  camera.height = size[1];
  return camera;
}

SceneBudget read_budget(const std::string& path, const toml::table& toml) {
  const StrictTable table(path, toml, "budget", {"bytes", "bake_ms", "target_error", "estimate_margin"}, kWholeFile);
  SceneBudget budget;
  const auto optional = [&](const char* key, const NumberRange& range, std::optional<double>& value) {
    if (table.has(key)) value = table.number(key, range, 0.0);
  };
  optional("bytes", kAboveZero, budget.bytes);
  optional("bake_ms", kAboveZero, budget.bake_ms);
  optional("target_error", kAboveZero, budget.target_error);
  budget.estimate_margin = table.number("estimate_margin", {0.0, 0.5, true, false, "a number above 0 and at most 0.5"},
                                        budget.estimate_margin);
  return budget;
}

void read_lights(const std::string& path, const StrictTable& root, SceneDescription& scene, bool reads_files) {
  std::size_t counts[2] = {};
  for (const toml::table* toml : root.tables("light", false)) {
    scene.lights.push_back(read_light(path, *toml));
    if (++counts[scene.lights.back().is_point ? 1 : 0] > kLightCountMax)
      root.refuse("light", fmt::format("has more than {} lights of one kind (distant or point)", kLightCountMax));
  }
  const StrictTable environment(path, root.table("environment"), "environment", {"file"}, kWholeFile);
  if (root.has("environment")) scene.environment = path_beside(path, environment.path("file"));
  if (reads_files) check_file(environment, "file", scene.environment);
  for (const SceneMaterial& material : scene.materials) {
    const std::string refusal = environment_refusal(material.brdfs.front());
    if (!scene.environment.empty() && !refusal.empty())
      root.refuse("environment", fmt::format("does not fit material \"{}\": {}", material.name, refusal));
  }
  if (scene.lights.empty() && scene.environment.empty())
    root.refuse("", "has no light, expected [[light]] or [environment]");
}

SceneDescription read_scene(const std::string& path, const BakeJob& pattern, bool reads_files) {
  const toml::table toml = parse_toml(path, "a scene as described in docs/reference/scenes.md");
  const StrictTable root(path, toml, "", {"camera", "budget", "map", "material", "object", "light", "environment"},
                         kWholeFile);
  SceneDescription scene;
  scene.camera = read_camera(path, root.table("camera"));
  scene.budget = read_budget(path, root.table("budget"));
  Names maps("map"), materials("material"), objects("object");
  const std::vector<const toml::table*> map_tables = root.tables("map");
  for (const toml::table* table : map_tables) scene.maps.push_back(read_map(path, *table, pattern, maps, reads_files));
  for (const toml::table* table : root.tables("material"))
    scene.materials.push_back(read_material(path, *table, materials, reads_files));
  for (const toml::table* table : root.tables("object"))
    scene.objects.push_back(read_object(path, *table, scene, objects, maps, materials));
  read_lights(path, root, scene, reads_files);
  for (std::size_t m = 0; m < scene.maps.size(); ++m)
    if (std::none_of(scene.objects.begin(), scene.objects.end(), [&](const SceneObject& o) { return o.map == m; }))
      map_table(path, *map_tables[m])
          .refuse("name", fmt::format("is \"{}\", which is not used by any [[object]]", scene.maps[m].name));
  return scene;
}

}  // namespace

SceneDescription read_scene(const std::string& path, const BakeJob& pattern) { return read_scene(path, pattern, true); }

std::vector<std::string> scene_files(const std::string& path) {
  const BakeJob pattern;  // a named object, because GCC 12 warns about empty braces
  const SceneDescription scene = read_scene(path, pattern, false);
  std::vector<std::string> files;
  for (const SceneMap& map : scene.maps)
    for (const std::string& file : input_files(map.job)) files.push_back(file);
  for (const SceneMaterial& material : scene.materials)
    if (!material.measured_file.empty()) files.push_back(material.measured_file);
  if (!scene.environment.empty()) files.push_back(scene.environment);
  return files;
}

}  // namespace multum
