// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/scene_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

const Json& object_named(const Json& plan, const std::string& path, const std::string& name) {
  const Json& objects = plan.at("objects");
  std::vector<std::string> names;
  for (const Json& object : objects) names.push_back(object.at("name").get<std::string>());
  if (name.empty() && names.size() == 1) return objects.front();
  const auto found = name.empty() ? names.end() : std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw Error(ErrorCode::kUsage,
                fmt::format("--object is {}, expected one of {}: {}", name.empty() ? "not given" : "\"" + name + "\"",
                            path, fmt::join(names, ", ")));
  return objects[static_cast<std::size_t>(found - names.begin())];
}

/// Reads an object's "view" from a plan, and sets the options that are not on the command line.
class PlanView {
 public:
  PlanView(const Json& view, fs::path folder) : view_(view), folder_(std::move(folder)) {}

  void apply(MapOptions& options) const {
    options.file = file("file");
    if (!options.comparison.pictures.empty()) apply_source(options.source);
    set_file("colour_map", options.picture.shading.colour_map);
    apply_lights(options.picture.light);
    apply_material(options.picture.material);
    set("camera", options.picture.camera.place, parse_camera);
    set("size", options.picture.output.size, parse_size);
    apply_repeat(options.picture.surface);
    if (view_.value("stored_only", false)) options.stored_only = true;
  }

 private:
  std::string resolved(const Json& path) const { return (folder_ / path_of_text(path.get<std::string>())).string(); }
  std::string file(const char* key) const { return resolved(view_.at(key)); }
  void set_file(const char* key, std::string& path) const {
    if (path.empty() && view_.contains(key)) path = file(key);
  }
  template <typename Value, typename Parse>
  void set(const char* key, std::optional<Value>& value, Parse parse) const {
    if (!value && view_.contains(key)) value = parse(key, view_.at(key).get<std::string>());
  }
  template <typename Value, typename Parse>
  void set_list(const char* key, std::vector<Value>& values, Parse parse) const {
    if (!values.empty()) return;
    for (const Json& text : view_.value(key, Json::array())) values.push_back(parse(key, text.get<std::string>()));
  }

  void apply_repeat(SurfaceOptions& surface) const {
    const auto repeat = view_.at("repeat").get<float>();
    if (!(repeat >= 1e-6f && repeat <= 1e6f))
      throw Error(ErrorCode::kInput, fmt::format("found the repeat {:g}, expected 1e-06 to 1e+06", repeat));
    if (!surface.repeat) surface.repeat = repeat;
  }
  void apply_source(SourceOptions& source) const {
    set_file("source", source.normals);
    set_file("albedo", source.albedo);
    set_file("roughness", source.roughness);
    set_file("gloss", source.gloss);
    set_file("weights", source.weights);
  }
  void apply_lights(LightOptions& light) const {
    set_list("light", light.distant, parse_light);
    set_list("point_light", light.points, parse_point_light);
    if (!view_.contains("environment")) return;
    set_file("environment", light.environment);
    // Prefiltered light is the default, except for files of harmonics.
    const auto mode = find_choice(kEnvironmentModes, view_.at("environment_mode").get<std::string>());
    if (!light.environment_mode && mode == gl::EnvironmentMode::kHarmonics) light.environment_mode = mode;
  }
  void apply_material(MaterialOptions& material) const {
    const bool is_measured = view_.contains("measured");
    if (material.brdfs.empty())
      for (const Json& brdf : view_.value("brdf", Json::array()))
        material.brdfs.push_back(is_measured ? resolved(brdf) : brdf.get<std::string>());
    set_list("diffuse", material.diffuse, parse_colour);
    set_list("specular", material.specular, parse_colour);
    set("fixed-fresnel", material.fixed_fresnel, parse_colour);
  }

  const Json& view_;
  fs::path folder_;
};

}  // namespace

void apply_scene_plan(MapOptions& options) {
  const std::string& path = options.plan;
  const std::optional<std::string> text = json_of_file(path, StandardInput::kAllowed);
  if (!text) throw Error(ErrorCode::kInput, path + ": no such file, expected a plan.json of multum bake scene.toml");
  const Json plan = Json::parse(*text, nullptr, false);
  if (!plan.is_object() || !plan.contains("objects"))
    throw Error(ErrorCode::kInput, path + ": is not a plan, expected a plan.json of multum bake scene.toml");
  try {
    PlanView(object_named(plan, path, options.object).at("view"), fs::path(path).parent_path()).apply(options);
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kInput, fmt::format("{}: this plan cannot be drawn: {}", path, error.what()));
  }
}

}  // namespace multum
