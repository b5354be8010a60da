// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/job_types.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <utility>

#include "host/farm/service/files/staging.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/udim_set.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/brdf_families/brdf_forms.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using Kind = ParameterKind;

std::vector<JobType>& registered_types() {
  static std::vector<JobType> types;
  return types;
}

// A job accepts less than a command line does. It accepts no control characters, and no files except for its inputs.
std::string expected_of_job(const Parameter& parameter) {
  return parameter.kind == Kind::kText ? "a string of up to 1000 characters without control characters"
                                       : expected_text(parameter);
}

std::optional<ParameterValue> value_of(const Json& json, Kind kind) {
  if (json.is_boolean()) return json.get<bool>();
  if (json.is_string()) return json.get<std::string>();
  if (json.is_number_integer() && kind != Kind::kNumber) {
    if (json.is_number_unsigned() && json.get<std::uint64_t>() > std::uint64_t{INT64_MAX}) return std::nullopt;
    return json.get<std::int64_t>();
  }
  if (json.is_number() && kind == Kind::kNumber) return json.get<double>();
  return std::nullopt;
}

[[noreturn]] void refuse_both(const std::string& name, const std::string& other) {
  throw Error(ErrorCode::kUsage,
              fmt::format("parameters.{} is given together with {}: expected only one of them", name, other));
}

bool is_accepted(const Parameter& parameter, const Json& json) {
  const std::optional<ParameterValue> value = value_of(json, parameter.kind);
  if (!value || !is_legal(parameter, *value)) return false;
  const auto* const text = std::get_if<std::string>(&*value);
  switch (parameter.kind) {
    case Kind::kText: return is_plain_text(*text);
    // Accepts only names of families, because a file name could lead out of the folders that jobs may read.
    case Kind::kBrdf: return text->size() < 100 && std::regex_match(*text, std::regex(brdf_pattern()));
    case Kind::kFile: return !text->empty() && text->size() < 4096 && text->find('\0') == std::string::npos;
    default: return true;
  }
}

// Formats a value for the command line. Files become the bytes of their paths.
std::string argument_text(const Parameter& parameter, const Json& value) {
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  return parameter.kind == Kind::kFile ? path_of_text(text) : text;
}

Json value_schema(const Parameter& parameter) {
  switch (parameter.kind) {
    case Kind::kFlag: return {{"type", "boolean"}};
    case Kind::kInteger:
    case Kind::kBytes:
      return {{"type", "integer"},
              {"minimum", static_cast<std::int64_t>(parameter.low)},
              {"maximum", static_cast<std::int64_t>(parameter.high)}};
    case Kind::kNumber: {
      Json schema = {{"type", "number"}};
      if (parameter.has_low()) schema[parameter.low_excluded ? "exclusiveMinimum" : "minimum"] = parameter.low;
      if (parameter.has_high()) schema["maximum"] = parameter.high;
      if (parameter.zero_excluded) schema["not"] = {{"const", 0}};
      return schema;
    }
    case Kind::kChoice: return {{"type", "string"}, {"enum", parameter.choices}};
    case Kind::kText: return {{"type", "string"}, {"maxLength", 1000}, {"pattern", kPlainPattern}};
    case Kind::kBrdf: return {{"type", "string"}, {"pattern", brdf_pattern()}};
    case Kind::kFile: return {{"type", "string"}, {"minLength", 1}, {"maxLength", 4095}, {"pattern", "^[^\\u0000]*$"}};
  }
  return {};
}

}  // namespace

bool is_plain_text(const std::string& text) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  // The C1 control characters, U+0080 to U+009F, take two bytes in UTF-8, and the first byte is always C2. A terminal
  // reads U+009B as ESC [.
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

const Parameter* JobType::find(const std::string& parameter) const {
  const Parameter* const found = table->find(parameter);
  return found != nullptr && found->is_on(kInService) ? found : nullptr;
}

const JobView* JobType::find_view(const std::string& file) const {
  for (const JobView& view : views)
    if (std::find(view.files.begin(), view.files.end(), file) != view.files.end()) return &view;
  return nullptr;
}

void register_job_types(std::vector<JobType> types) {
  MULTUM_CHECK(registered_types().empty());
  for (const JobType& type : types) MULTUM_CHECK(type.table != nullptr && type.command.empty() == bool(type.run));
  registered_types() = std::move(types);
}

const std::vector<JobType>& job_types() {
  MULTUM_CHECK(!registered_types().empty());
  return registered_types();
}

const JobType& find_job_type(std::string_view name) {
  std::vector<std::string> names;
  for (const JobType& type : job_types()) {
    if (type.name == name) return type;
    names.push_back(type.name);
  }
  throw Error(ErrorCode::kUsage, fmt::format("type is \"{}\", expected one of {}", name, fmt::join(names, ", ")));
}

void check_parameters(const JobType& type, const Json& parameters) {
  if (!parameters.is_object()) throw Error(ErrorCode::kUsage, "parameters is not an object");
  for (const auto& [name, value] : parameters.items()) {
    const Parameter* parameter = type.find(name);
    if (parameter == nullptr) {
      const std::string nearest = nearest_name(name, type.table->names(kInService));
      throw Error(ErrorCode::kUsage, fmt::format("unknown parameter '{}' of {}{}", name.substr(0, 60), type.name,
                                                 nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
    }
    if (!is_accepted(*parameter, value))
      throw Error(ErrorCode::kUsage,
                  fmt::format("parameters.{} is {}, expected {}", name, shortened(value), expected_of_job(*parameter)));
    for (const std::string& excluded : parameter->excludes)
      if (parameters.contains(excluded)) refuse_both(name, excluded);
  }
  if (!type.input.empty() && !parameters.contains(type.input))
    throw Error(ErrorCode::kUsage, fmt::format("parameters.{} is missing, expected the path of a file", type.input));
}

void check_input(const JobType& type, const Json& parameters) {
  if (type.input.empty()) return;
  const std::string file = parameters.at(type.input).get<std::string>();
  const auto refuse = [&](const std::string& expected) {
    throw Error(ErrorCode::kUsage, fmt::format("parameters.{} is {}, expected {}", type.input, file, expected));
  };
  for (const RefusedInput& refused : type.refused_inputs)
    if (file.ends_with(refused.extension)) refuse(refused.expected);
  if (type.input_is_one_map && has_udim(file)) refuse("one map, not a set");
}

Json parameters_schema(const JobType& type) {
  Json properties = Json::object();
  std::set<std::pair<std::string, std::string>> both;  // pairs of names that exclude each other
  for (const Parameter& parameter : type.table->rows()) {
    if (!parameter.is_on(kInService)) continue;
    Json one = value_schema(parameter);
    one["description"] = parameter.help;
    if (!parameter.default_text.empty())
      one["description"] = parameter.help + " (default: " + parameter.default_text + ")";
    properties[parameter.name] = one;
    for (const std::string& excluded : parameter.excludes) both.insert(std::minmax(parameter.name, excluded));
  }
  Json schema = {{"type", "object"}, {"properties", properties}, {"additionalProperties", false}};
  if (!type.input.empty()) schema["required"] = {type.input};
  for (const auto& [name, other] : both) schema["not"]["anyOf"].push_back({{"required", {name, other}}});
  return schema;
}

std::vector<std::string> job_arguments(const JobType& type, const Json& parameters, const std::string& output) {
  std::vector<std::string> arguments = {type.command.empty() ? type.name : type.command};
  for (const auto& [name, value] : parameters.items()) {
    if (name == type.input) continue;
    const std::string option = type.table->at(name).option();
    // Writes "--a=b", so that a value that begins with a dash is not taken for an option.
    if (value.is_boolean()) {
      if (value.get<bool>()) arguments.push_back(option);
    } else {
      arguments.push_back(option + "=" + argument_text(type.table->at(name), value));
    }
  }
  arguments.insert(arguments.end(), type.fixed_options.begin(), type.fixed_options.end());
  if (!output.empty()) arguments.push_back("--output=" + output);
  if (!type.input.empty()) {
    arguments.push_back("--");  // prevents file names from being read as options
    arguments.push_back(path_of_text(parameters.at(type.input).get<std::string>()));
  }
  return arguments;
}

std::vector<std::string> input_files(const JobType& type, const Json& parameters) {
  std::vector<std::string> files;
  for (const Parameter& parameter : type.table->rows())
    if (parameter.kind == Kind::kFile && parameters.contains(parameter.name))
      files.push_back(path_of_text(parameters.at(parameter.name).get<std::string>()));
  if (type.files_of_input != nullptr) {
    const std::vector<std::string> named =
        type.files_of_input(path_of_text(parameters.at(type.input).get<std::string>()));
    files.insert(files.end(), named.begin(), named.end());
  }
  return files;
}

std::string input_identity(const JobType& type, const Json& parameters) {
  if (type.input.empty()) return "";
  Json identities = Json::array();
  try {
    for (const std::string& file : input_files(type, parameters))
      identities.push_back({text_of_path(file), file_identity(file)});
  } catch (const Error& unreadable) {
    identities.push_back(unreadable.what());
  }
  return hash_text(identities.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string idempotency_key(const JobType& type, const Json& parameters, const std::vector<std::string>& file_hashes) {
  Json without_names = parameters;
  for (const Parameter& parameter : type.table->rows())
    if (parameter.kind == Kind::kFile && without_names.contains(parameter.name)) without_names[parameter.name] = true;
  // A manifest of inferred textures names its scene file, and a plan names an environment. The key must therefore tell
  // which file has which role.
  if (type.files_of_input != nullptr) without_names[type.input] = parameters.at(type.input);
  return hash_text(
      Json{{"type", type.name}, {"parameters", without_names}, {"files", file_hashes}, {"version", MULTUM_VERSION}}
          .dump());
}

}  // namespace multum
