// SPDX-License-Identifier: Apache-2.0
#include "host/farm/openjd/openjd_bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host/farm/openjd/openjd_limits.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// On SIGTERM, multum stops and leaves files from which a run with --resume continues.
constexpr int kNoticeSeconds = 30;
// The duration of the work that a farm gives to one process. Starting a process, including its OpenCL programs, takes a
// second or less.
constexpr int kChunkSeconds = 60;

std::string absolute(const std::string& path) {
  const fs::path normal = fs::absolute(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();  // without a final slash
}

std::vector<std::string> all_absolute(std::vector<std::string> paths) {
  for (std::string& path : paths) path = absolute(path);
  std::sort(paths.begin(), paths.end());
  paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
  return paths;
}

// Returns a parameter name for each path. Inputs are named Input, Input2 and so on, and outputs are named Output,
// Output2 and so on.
std::vector<std::string> parameter_names(const FarmCommand& command) {
  std::vector<std::string> names;
  int inputs = 0, outputs = 0;
  for (const FarmWord& path : command.paths) {
    int& count = path.is_output ? outputs : inputs;
    names.push_back(
        fmt::format("{}{}", path.is_output ? "Output" : "Input", ++count == 1 ? "" : std::to_string(count)));
  }
  return names;
}

// In strings of a template, {{ begins a reference and }} ends it. They cannot be escaped.
void check_word(const std::string& word) {
  for (const char* braces : {"{{", "}}"})
    if (word.find(braces) != std::string::npos)
      throw Error(ErrorCode::kUsage, word + ": holds " + braces +
                                         ", which marks a reference in Open Job Description; expected another name");
}

std::vector<std::string> template_words(const FarmCommand& command, const std::vector<std::string>& more) {
  std::vector<std::string> words = command.words;
  for (const std::string& word : words) check_word(word);
  const std::vector<std::string> names = parameter_names(command);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const FarmWord& path = command.paths[i];
    std::string& word = words.at(path.word);
    const std::size_t at = word.find(path.path);
    MULTUM_CHECK(at != std::string::npos);
    word.replace(at, path.path.size(), "{{Param." + names[i] + "}}");
  }
  words.insert(words.end(), more.begin(), more.end());
  words.emplace_back("--openjd");
  return words;
}

FarmJson step(const FarmCommand& command, const std::string& name, const std::vector<std::string>& more) {
  FarmJson run = {{"command", "{{Param.Multum}}"},
                  {"args", template_words(command, more)},
                  {"cancelation", {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", kNoticeSeconds}}}};
  FarmJson result = {{"name", name}, {"script", {{"actions", {{"onRun", run}}}}}};
  if (command.threads > 0)
    result["hostRequirements"] = {{"amounts", {{{"name", "amount.worker.vcpu"}, {"min", command.threads}}}}};
  return result;
}

std::vector<std::string> share_words(const FarmCommand& command) {
  return {"--shard", fmt::format("{{{{Task.Param.Shard}}}}/{}", command.shards)};
}

void add_shards(FarmJson& step, FarmJson parameter) {
  step["parameterSpace"] = {{"taskParameterDefinitions", FarmJson::array({std::move(parameter)})}};
}

void add_dependency(FarmJson& step, const char* name) {
  step["dependencies"] = FarmJson::array({FarmJson{{"dependsOn", name}}});
}

FarmJson merge_step(const FarmCommand& command, const char* after) {
  FarmJson merge = step(command, "Merge", {"--merge", std::to_string(command.shards)});
  add_dependency(merge, after);
  return merge;
}

FarmJson steps_of(const FarmCommand& command) {
  if (command.shards == 1) return FarmJson::array({step(command, "Run", {})});
  const std::string range = fmt::format("1-{}", command.shards);
  if (!command.is_one_map) {
    FarmJson run = step(command, command.is_merged ? "Shares" : "Run", share_words(command));
    const FarmJson chunks = {
        {"defaultTaskCount", 1}, {"targetRuntimeSeconds", kChunkSeconds}, {"rangeConstraint", "CONTIGUOUS"}};
    add_shards(run, {{"name", "Shard"}, {"type", "CHUNK[INT]"}, {"range", range}, {"chunks", chunks}});
    return command.is_merged ? FarmJson::array({run, merge_step(command, "Shares")}) : FarmJson::array({run});
  }
  FarmJson bands = step(command, "Bands", share_words(command));
  add_shards(bands, {{"name", "Shard"}, {"type", "INT"}, {"range", range}});
  add_dependency(bands, "Coarse");
  return FarmJson::array(
      {step(command, "Coarse", {"--shard", fmt::format("0/{}", command.shards)}), bands, merge_step(command, "Bands")});
}

// Files of sets and scenes that are not on the command line appear only in the asset references.
void check_texts(const FarmJson& value) {
  if (value.is_string()) return check_openjd_text(value.get<std::string>(), value.get<std::string>());
  for (const FarmJson& own : value) check_texts(own);
}

void append_yaml(const FarmJson& value, int indent, bool is_in_list, std::string& out) {
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  bool is_first = true;
  const auto begin_line = [&] {
    if (!is_first || !is_in_list) out += margin;
    is_first = false;
  };
  const auto append_value = [&](const FarmJson& own, int own_indent) {
    if (own.is_structured() && !own.empty()) {
      out += '\n';
      append_yaml(own, own_indent, false, out);
    } else {
      out += ' ' + escaped_json(own.dump()) + '\n';
    }
  };
  if (value.is_object()) {
    for (const auto& [key, own] : value.items()) {
      begin_line();
      out += key + ':';
      append_value(own, indent + 2);
    }
    return;
  }
  for (const FarmJson& own : value) {
    begin_line();
    out += '-';
    if (own.is_object() && !own.empty()) {
      out += ' ';
      append_yaml(own, indent + 2, true, out);
    } else {
      append_value(own, indent + 2);
    }
  }
}

}  // namespace

FarmJson openjd_template(const FarmCommand& command) {
  FarmJson parameters = FarmJson::array();
  const std::vector<std::string> names = parameter_names(command);
  for (std::size_t i = 0; i < names.size(); ++i)
    parameters.push_back({{"name", names[i]},
                          {"type", "PATH"},
                          {"objectType", command.paths[i].is_folder ? "DIRECTORY" : "FILE"},
                          {"dataFlow", command.paths[i].is_output ? "OUT" : "IN"}});
  parameters.push_back({{"name", "Multum"},
                        {"type", "STRING"},
                        {"default", "multum"},
                        {"description", "Name of the program in PATH, or its path on the workers."}});
  FarmJson job = {{"specificationVersion", "jobtemplate-2023-09"}};
  if (command.shards > 1 && !command.is_one_map) job["extensions"] = {"TASK_CHUNKING"};
  check_word(command.name);
  job["name"] = command.name;
  job["parameterDefinitions"] = parameters;
  job["steps"] = steps_of(command);
  return job;
}

FarmJson openjd_parameter_values(const FarmCommand& command) {
  FarmJson values = FarmJson::array();
  const std::vector<std::string> names = parameter_names(command);
  for (std::size_t i = 0; i < names.size(); ++i)
    values.push_back({{"name", names[i]}, {"value", absolute(command.paths[i].path)}});
  return {{"parameterValues", values}};
}

std::vector<std::string> openjd_input_files(const FarmCommand& command) { return all_absolute(command.inputs); }

int openjd_task_count(const FarmCommand& command) {
  const int more = command.is_one_map ? 2 : command.is_merged ? 1 : 0;
  return command.shards == 1 ? 1 : command.shards + more;
}

FarmJson openjd_asset_references(const FarmCommand& command) {
  return {
      {"assetReferences",
       {{"inputs", {{"filenames", openjd_input_files(command)}, {"directories", all_absolute(command.input_folders)}}},
        {"outputs", {{"directories", all_absolute(command.output_folders)}}},
        {"referencedPaths", FarmJson::array()}}}};
}

std::string yaml_text(const FarmJson& value) {
  std::string text;
  append_yaml(value, 0, false, text);
  return text;
}

void write_openjd_bundle(const FarmCommand& command, const std::string& folder) {
  const FarmJson job = openjd_template(command), values = openjd_parameter_values(command);
  check_openjd_limits(job, values);
  const FarmJson assets = openjd_asset_references(command);
  check_texts(assets);
  const std::string texts[] = {yaml_text(job), yaml_text(values), yaml_text(assets)};
  make_folder(folder);
  const char* const names[] = {"template.yaml", "parameter_values.yaml", "asset_references.yaml"};
  for (std::size_t i = 0; i < 3; ++i) write_text_file(folder + "/" + names[i], texts[i]);
}

}  // namespace multum
