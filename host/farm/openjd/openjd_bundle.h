// SPDX-License-Identifier: Apache-2.0
// Writes a command line of multum as a job bundle of Open Job Description, as render farms read them: AWS Deadline
// Cloud, OpenCue, the project's own openjd-cli. github.com/OpenJobDescription/openjd-specifications: "Template
// Schemas", 2023-09, and RFC 0001, TASK_CHUNKING.
//
//   FOLDER/
//     template.yaml           the job: its parameters, one step, a task for each share of the maps
//     parameter_values.yaml   the paths, as they are here
//     asset_references.yaml   every file that is read, every folder that is written to
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multum {

/// A file or folder that a word of the command line names.
struct FarmWord {
  std::size_t word = 0;  // which; the path is a part of it
  std::string path;
  bool is_folder = false, is_output = false;
};

struct FarmCommand {
  std::string name;                                // of the job, for people
  std::vector<std::string> words;                  // behind `multum`
  std::vector<FarmWord> paths;                     // in order of the words
  std::vector<std::string> inputs, input_folders;  // all that is read, through those words and beyond them
  std::vector<std::string> output_folders;
  bool is_one_map = false;  // shares are of one map: its coarse levels, bands, and what puts them together
  bool is_merged = false;   // shares of a scene, or of inference: `--merge` comes behind them
  int shards = 1;           // tasks; more than one: `--shard` is added
  int threads = 0;          // that a task takes; 0: not said
};

using FarmJson = nlohmann::ordered_json;

/// Each path of the words becomes a parameter of type PATH, so that a farm may put files elsewhere.
FarmJson openjd_template(const FarmCommand& command);
FarmJson openjd_parameter_values(const FarmCommand& command);
FarmJson openjd_asset_references(const FarmCommand& command);

/// Absolute and sorted, each once.
std::vector<std::string> openjd_input_files(const FarmCommand& command);
/// Of all steps: shares, and what comes before and after them.
int openjd_task_count(const FarmCommand& command);

/// YAML 1.2 of objects, lists, texts, numbers and booleans, in blocks; texts are in double quotes.
std::string yaml_text(const FarmJson& value);

/// Writes the three files; the folder is made. Throws Error(kUsage) where the specification's limits do not allow the
/// job (host/farm/openjd/openjd_limits.h), before anything is written; Error(kEnvironment).
void write_openjd_bundle(const FarmCommand& command, const std::string& folder);

}  // namespace multum
