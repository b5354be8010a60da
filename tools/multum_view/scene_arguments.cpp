// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/scene_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/error.h"

namespace multum {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

// Takes "--name VALUE" or "--name=VALUE" out of the arguments.
std::optional<std::string> take(std::vector<std::string>& arguments, const std::string& name) {
  for (auto i = arguments.begin(); i != arguments.end(); ++i) {
    if (i->starts_with(name + "=")) {
      const std::string value = i->substr(name.size() + 1);
      arguments.erase(i);
      return value;
    }
    if (*i != name) continue;
    if (i + 1 == arguments.end()) throw Error(ErrorCode::kUsage, name + ": expected a value");
    const std::string value = *(i + 1);
    arguments.erase(i, i + 2);
    return value;
  }
  return std::nullopt;
}

const Json& object_named(const Json& plan, const std::string& path, const std::optional<std::string>& name) {
  const Json& objects = plan.at("objects");
  std::vector<std::string> names;
  for (const Json& object : objects) names.push_back(object.at("name").get<std::string>());
  if (!name && names.size() == 1) return objects.front();
  const auto found = name ? std::find(names.begin(), names.end(), *name) : names.end();
  if (found == names.end())
    throw Error(ErrorCode::kUsage, fmt::format("--object is {}, expected one of {}: {}",
                                               name ? "\"" + *name + "\"" : "not given", path, fmt::join(names, ", ")));
  return objects[static_cast<std::size_t>(found - names.begin())];
}

bool is_given(const std::vector<std::string>& arguments, const std::string& option) {
  return std::any_of(arguments.begin(), arguments.end(),
                     [&](const std::string& a) { return a == option || a.starts_with(option + "="); });
}

std::vector<std::string> arguments_of(const Json& view, const fs::path& folder, const std::vector<std::string>& given) {
  const auto resolved = [&](const Json& file) { return (folder / file.get<std::string>()).string(); };
  std::vector<std::string> arguments = {resolved(view.at("file"))};
  const auto add = [&](const std::string& option, const std::string& value) {
    if (!is_given(given, option)) arguments.push_back(option + "=" + value);
  };
  if (is_given(given, "--compare"))
    for (const char* key : {"source", "albedo", "roughness", "gloss", "weights"})
      if (view.contains(key)) add(std::string("--") + key, resolved(view[key]));
  if (view.contains("colour_map")) add("--colour-map", resolved(view["colour_map"]));
  if (view.contains("environment")) {
    add("--environment", resolved(view["environment"]));
    add("--environment-mode", view.at("environment_mode"));
  }
  for (const Json& brdf : view.value("brdf", Json::array()))
    add("--brdf", view.contains("measured") ? resolved(brdf) : brdf.get<std::string>());
  for (const char* key : {"diffuse", "specular"})
    for (const Json& colour : view.value(key, Json::array())) add(std::string("--") + key, colour);
  for (const char* key : {"fixed-fresnel", "size", "camera"})
    if (view.contains(key)) add(std::string("--") + key, view[key]);
  add("--repeat", fmt::format("{:.9g}", view.at("repeat").get<double>()));
  for (const Json& light : view.at("light")) add("--light", light);
  for (const Json& light : view.at("point_light")) add("--point-light", light);
  if (view.value("stored_only", false)) arguments.emplace_back("--stored-only");
  return arguments;
}

}  // namespace

std::vector<std::string> with_scene(const std::vector<std::string>& arguments) {
  std::vector<std::string> rest(arguments.begin() + 1, arguments.end());
  const std::optional<std::string> path = take(rest, "--scene");
  if (!path) return arguments;
  const std::optional<std::string> name = take(rest, "--object");
  if (std::error_code error; !fs::is_regular_file(*path, error))
    throw Error(ErrorCode::kInput, *path + ": no such file, expected plan.json as multum bake scene.toml writes it");
  if (!rest.empty() && !rest.front().starts_with("-"))
    throw Error(ErrorCode::kUsage, "--scene says what is drawn; found " + rest.front() + " beside it");
  std::ifstream file(*path);
  const Json plan = Json::parse(file, nullptr, false);
  if (!plan.is_object() || !plan.contains("objects"))
    throw Error(ErrorCode::kInput, *path + ": is no plan, expected plan.json as multum bake scene.toml writes it");
  std::vector<std::string> all = {arguments.front()};
  try {
    const Json& view = object_named(plan, *path, name).at("view");
    for (std::string& argument : arguments_of(view, fs::path(*path).parent_path(), rest))
      all.push_back(std::move(argument));
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kInput, fmt::format("{}: is no plan that can be drawn: {}", *path, error.what()));
  }
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

}  // namespace multum
