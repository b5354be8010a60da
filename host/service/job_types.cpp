// SPDX-License-Identifier: Apache-2.0
#include "host/service/job_types.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "host/asset/representation.h"
#include "host/bake/animation_job_reading.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/nearest_name.h"
#include "host/scene/scene_file.h"
#include "host/service/staging.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using Kind = ParameterKind;

constexpr std::int64_t kMiB = 1 << 20;
constexpr const char* kPlainPattern = "^[^\\u0000-\\u001f\\u007f-\\u009f]*$";  // what is_plain_text() takes

// A BRDF of a family: no file's name, which would be looked for beyond the folders that jobs may read.
constexpr const char* kBrdfPattern = "^(lambert|(blinn-phong|torrance-sparrow|cook-torrance|ggx):[0-9.,eE+-]{1,60})$";

// As `multum bake --ndf` has them.
std::vector<std::string> ndf_names() {
  std::vector<std::string> names;
  for (const RepresentationInfo& info : representations()) names.emplace_back(info.option);
  return names;
}

JobType bake_type() {
  return {"bake",
          "a normal map or height field into a mipmap of normal distributions",
          "bake",
          "input",
          true,
          true,
          false,
          ".ndf.exr",
          1024 * kMiB,
          {{"input", Kind::kInputFile, "PNG, TIFF, EXR, JPEG or WebP, sides to 32768"},
           {"albedo", Kind::kInputFile, "colour map of the same size: bakes colours, per lobe or averaged"},
           {"roughness", Kind::kInputFile,
            "roughness map of the same size: bakes the BRDF's width in; its G, or only "
            "channel"},
           {"weights", Kind::kInputFile, "map of the same size, a channel a basis BRDF: bakes their weights"},
           {"ndf", Kind::kChoice, "what texels hold", 0, 0, ndf_names()},
           {"sh_order", Kind::kWhole, "of sh: spherical harmonics up to this l", 1, 20},
           {"lobes", Kind::kWhole, "lobes a texel", 1, 8},
           {"reference", Kind::kFlag, "every normal at every level, none cut short"},
           {"iterations", Kind::kWhole, "EM iterations a texel, at most", 1, 1000},
           {"sweeps", Kind::kWhole, "times that a level is fitted", 1, 16},
           {"order", Kind::kChoice, "in which texels are fitted", 0, 0, {"colour", "scanline"}},
           {"align", Kind::kNumber, "weight of the alignment prior", 0, 1e6},
           {"kappa_cap", Kind::kNumber, "sharpest lobe on rough texels", 1, 1e9},
           {"first_level", Kind::kWhole, "finest level to store", 0, 15},
           {"data_format", Kind::kChoice, "what is stored is rounded to", 0, 0, {"snorm16", "half", "float"}},
           {"compression", Kind::kText, "none, rle, zips, zip or piz, zip:1..9"},
           {"wrap", Kind::kChoice, "beyond the border", 0, 0, {"auto", "black", "clamp", "periodic", "mirror"}},
           {"green", Kind::kChoice, "which way the green channel points", 0, 0, {"up", "down"}},
           {"height_scale", Kind::kNumber, "of a height field, texels", 1e-6, 1e6},
           {"normal_scale", Kind::kNumber, "of a normal map: x and y times this", -1e6, 1e6},
           {"memory", Kind::kWhole, "bytes of resident memory to stay within", 1 << 26, 1e15},
           {"device", Kind::kText, "OpenCL device: a number of `multum devices` or part of a name"},
           {"target_error", Kind::kNumber,
            "choose the cheapest settings that come within this relative L1 of the truth", 1e-9, 2},
           {"budget_ms", Kind::kNumber, "choose the most accurate settings that bake in this time", 1e-3, 1e9},
           {"brdf", Kind::kBrdf,
            "for which settings are chosen: lambert, blinn-phong:S, ggx:ROUGHNESS or torrance-sparrow:SIGMA"},
           {"best_effort", Kind::kFlag, "write the best that was reached where nothing reaches the target"},
           {"no_measure", Kind::kFlag, "skip measuring the error of what is written"}}};
}

JobType scene_type() {
  return {"scene",
          "the maps of a scene, each as the scene needs it",
          "bake",
          "scene",
          true,
          true,
          true,
          "",
          1024 * kMiB,
          {{"scene", Kind::kInputFile, "scene.toml: maps, materials, objects, lights, camera"},
           {"memory", Kind::kWhole, "bytes of resident memory to stay within", 1 << 26, 1e15},
           {"device", Kind::kText, "OpenCL device: a number of `multum devices` or part of a name"}}};
}

JobType infer_type() {
  return {"infer",
          "textures from ray-traced pictures",
          "infer",
          "job",
          true,
          true,
          true,
          "",
          2048 * kMiB,
          {{"job", Kind::kInputFile, "animation.toml, as `multum animation` writes it"},
           {"hold_out", Kind::kWhole, "every such view is left out of layers that do not depend on views", 2, 1000},
           {"tolerance", Kind::kNumber, "relative gradient at which a texture is solved", 1e-7, 1},
           {"iterations", Kind::kWhole, "at most", 1, 100000},
           {"no_frames", Kind::kFlag, "draw no frames"},
           {"no_comparison", Kind::kFlag, "do not compare ways to infer"},
           {"report_sample", Kind::kText, "of the report's pictures"},
           {"context", Kind::kChoice, "GL to infer for", 0, 0, {"auto", "osmesa", "egl"}},
           {"device", Kind::kText, "OpenCL device: a number of `multum devices` or part of a name"}}};
}

JobType drill_type() {
  return {"drill",
          "does nothing, or fails as asked: for trying out queues, limits and alarms",
          "",
          "",
          true,
          false,
          false,
          "",
          0,
          {{"seconds", Kind::kNumber, "how long it takes", 0, 86400},
           {"then",
            Kind::kChoice,
            "how it ends: well, with an error worth trying again, with one that is not, by crashing, or not at all, "
            "deaf to its heartbeat or making no progress",
            0,
            0,
            {"succeed", "fail", "refuse", "crash", "hang", "stall"}},
           {"text", Kind::kText, "written to the output"}}};
}

const JobParameter* find_parameter(const JobType& type, const std::string& name) {
  const auto found = std::find_if(type.parameters.begin(), type.parameters.end(),
                                  [&](const JobParameter& one) { return one.name == name; });
  return found == type.parameters.end() ? nullptr : &*found;
}

std::string expected_text(const JobParameter& parameter) {
  switch (parameter.kind) {
    case Kind::kFlag: return "true or false";
    case Kind::kWhole: return fmt::format("a whole number from {:.0f} to {:.0f}", parameter.least, parameter.most);
    case Kind::kNumber: return fmt::format("a number from {:g} to {:g}", parameter.least, parameter.most);
    case Kind::kChoice: return fmt::format("one of {}", fmt::join(parameter.choices, ", "));
    case Kind::kText: return "a text of up to 1000 characters without control characters";
    case Kind::kBrdf: return "lambert, blinn-phong:S, torrance-sparrow:SIGMA, cook-torrance:SIGMA or ggx:ROUGHNESS";
    case Kind::kInputFile: return "a file's path";
  }
  return "";
}

bool is_accepted(const JobParameter& parameter, const Json& value) {
  switch (parameter.kind) {
    case Kind::kFlag: return value.is_boolean();
    case Kind::kWhole:
      return value.is_number_integer() && value.get<double>() >= parameter.least &&
             value.get<double>() <= parameter.most;
    case Kind::kNumber:
      return value.is_number() && value.get<double>() >= parameter.least && value.get<double>() <= parameter.most;
    case Kind::kChoice:
      return value.is_string() && std::find(parameter.choices.begin(), parameter.choices.end(),
                                            value.get<std::string>()) != parameter.choices.end();
    case Kind::kText: return value.is_string() && is_plain_text(value.get<std::string>());
    case Kind::kBrdf:
      return value.is_string() && value.get<std::string>().size() < 100 &&
             std::regex_match(value.get<std::string>(), std::regex(kBrdfPattern));
    case Kind::kInputFile:
      return value.is_string() && !value.get<std::string>().empty() && value.get<std::string>().size() < 4096 &&
             value.get<std::string>().find('\0') == std::string::npos;
  }
  return false;
}

}  // namespace

bool is_plain_text(const std::string& text) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  // C1, U+0080 to U+009F: in UTF-8 two bytes, the first always C2. A terminal takes U+009B for ESC [.
  const auto is_c1 = [](char first, char second) {
    return first == '\xc2' && static_cast<unsigned char>(second) >= 0x80 && static_cast<unsigned char>(second) < 0xa0;
  };
  const auto begins_character = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; };  // UTF-8
  return std::count_if(text.begin(), text.end(), begins_character) <= 1000 &&
         std::none_of(text.begin(), text.end(), is_control) &&
         std::adjacent_find(text.begin(), text.end(), is_c1) == text.end();
}

std::string shortened(const Json& value) {
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

const std::vector<JobType>& job_types() {
  static const std::vector<JobType> types = {bake_type(), scene_type(), infer_type(), drill_type()};
  return types;
}

const JobType& find_job_type(const std::string& name) {
  std::vector<std::string> names;
  for (const JobType& type : job_types()) {
    if (type.name == name) return type;
    names.push_back(type.name);
  }
  throw Error(ErrorCode::kUsage, fmt::format("type is \"{}\", expected one of {}", name, fmt::join(names, ", ")));
}

void check_parameters(const JobType& type, const Json& parameters) {
  if (!parameters.is_object()) throw Error(ErrorCode::kUsage, "parameters is no object");
  for (const auto& [name, value] : parameters.items()) {
    const JobParameter* parameter = find_parameter(type, name);
    if (parameter == nullptr) {
      std::vector<std::string> known;
      for (const JobParameter& one : type.parameters) known.push_back(one.name);
      const std::string nearest = nearest_name(name, known);
      throw Error(ErrorCode::kUsage, fmt::format("parameters.{} is no parameter of {}{}", name.substr(0, 60), type.name,
                                                 nearest.empty() ? "" : "; did you mean " + nearest + "?"));
    }
    if (!is_accepted(*parameter, value))
      throw Error(ErrorCode::kUsage,
                  fmt::format("parameters.{} is {}, expected {}", name, shortened(value), expected_text(*parameter)));
  }
  if (!type.input.empty() && !parameters.contains(type.input))
    throw Error(ErrorCode::kUsage, fmt::format("parameters.{} is missing, expected a file's path", type.input));
}

void check_is_one_map(const JobType& type, const Json& parameters) {
  if (type.name != "bake") return;
  const std::string file = parameters.at(type.input).get<std::string>();
  if (file.ends_with(".toml"))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("parameters.{} is {}, expected a map; a scene is baked by a job of type scene", type.input, file));
  if (file.find("<UDIM>") != std::string::npos)
    throw Error(ErrorCode::kUsage, fmt::format("parameters.{} is {}, expected one map, no set", type.input, file));
}

Json parameters_schema(const JobType& type) {
  Json properties = Json::object();
  for (const JobParameter& parameter : type.parameters) {
    Json one = {{"description", parameter.help}};
    switch (parameter.kind) {
      case Kind::kFlag: one["type"] = "boolean"; break;
      case Kind::kWhole:
        one.update({{"type", "integer"},
                    {"minimum", static_cast<std::int64_t>(parameter.least)},
                    {"maximum", static_cast<std::int64_t>(parameter.most)}});
        break;
      case Kind::kNumber:
        one.update({{"type", "number"}, {"minimum", parameter.least}, {"maximum", parameter.most}});
        break;
      case Kind::kChoice: one.update({{"type", "string"}, {"enum", parameter.choices}}); break;
      case Kind::kText: one.update({{"type", "string"}, {"maxLength", 1000}, {"pattern", kPlainPattern}}); break;
      case Kind::kBrdf: one.update({{"type", "string"}, {"pattern", kBrdfPattern}}); break;
      case Kind::kInputFile:
        one.update({{"type", "string"}, {"minLength", 1}, {"maxLength", 4095}, {"pattern", "^[^\\u0000]*$"}});
        break;
    }
    properties[parameter.name] = one;
  }
  Json schema = {{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!type.input.empty()) schema["required"] = {type.input};
  return schema;
}

std::vector<std::string> job_arguments(const JobType& type, const Json& parameters, const std::string& output) {
  std::vector<std::string> arguments = {type.command.empty() ? type.name : type.command};
  for (const auto& [name, value] : parameters.items()) {
    if (name == type.input) continue;
    std::string option = "--" + name;
    std::replace(option.begin(), option.end(), '_', '-');
    // "--a=b": a value that begins with a dash is no option.
    if (value.is_boolean()) {
      if (value.get<bool>()) arguments.push_back(option);
    } else {
      arguments.push_back(option + "=" + (value.is_string() ? value.get<std::string>() : value.dump()));
    }
  }
  if (!output.empty()) arguments.push_back("--output=" + output);
  if (!type.input.empty()) {
    arguments.push_back("--");  // nor is a file's name
    arguments.push_back(parameters.at(type.input).get<std::string>());
  }
  return arguments;
}

std::vector<std::string> input_files(const JobType& type, const Json& parameters) {
  std::vector<std::string> files;
  for (const JobParameter& parameter : type.parameters)
    if (parameter.kind == Kind::kInputFile && parameters.contains(parameter.name))
      files.push_back(parameters.at(parameter.name).get<std::string>());
  if (type.output_is_folder) {
    const std::vector<std::string> named =
        type.command == "infer" ? animation_job_files(files.front()) : scene_files(files.front());
    files.insert(files.end(), named.begin(), named.end());
  }
  return files;
}

std::string input_identity(const JobType& type, const Json& parameters) {
  if (type.input.empty()) return "";
  Json identities = Json::array();
  try {
    for (const std::string& file : input_files(type, parameters)) identities.push_back({file, file_identity(file)});
  } catch (const Error& unreadable) {
    identities.push_back(unreadable.what());
  }
  return hash_text(identities.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string idempotency_key(const JobType& type, const Json& parameters, const std::vector<std::string>& file_hashes) {
  Json without_names = parameters;
  for (const JobParameter& parameter : type.parameters)
    if (parameter.kind == Kind::kInputFile && without_names.contains(parameter.name))
      without_names[parameter.name] = true;
  // A manifest of inferred textures names its scene file, as a plan does an environment, and which file is which
  // matters there.
  if (type.output_is_folder) without_names[type.input] = parameters.at(type.input);
  return hash_text(
      Json{{"type", type.name}, {"parameters", without_names}, {"files", file_hashes}, {"version", MULTUM_VERSION}}
          .dump());
}

}  // namespace multum
