// SPDX-License-Identifier: Apache-2.0
// Writes a command line of multum as a job bundle of Open Job Description. Render farms read such bundles, for example
// AWS Deadline Cloud, OpenCue, and the openjd-cli of the Open Job Description project.
// github.com/OpenJobDescription/openjd-specifications: "Template Schemas", 2023-09, and RFC 0001, TASK_CHUNKING.
//
//   FOLDER/
//     template.yaml           the job: its parameters, one step, one task per share of the maps
//     parameter_values.yaml   the paths on this machine
//     asset_references.yaml   every input file, and every output folder
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multum {

/// A file or folder that a word of the command line names.
struct FarmWord {
  std::size_t word = 0;  // index of the word, which contains the path
  std::string path;
  bool is_folder = false, is_output = false;
};

struct FarmCommand {
  std::string name;                                // human-readable name of the job
  std::vector<std::string> words;                  // the words after `multum`
  std::vector<FarmWord> paths;                     // files and folders, in the order of the words
  std::vector<std::string> inputs, input_folders;  // all inputs, whether the words name them or not
  std::vector<std::string> output_folders;
  bool is_one_map = false;  // shares of one map: its coarse levels, its bands, and their merge
  bool is_merged = false;   // shares of a scene or of an inference, followed by `--merge`
  int shards = 1;           // number of tasks; more than one adds `--shard`
  int threads = 0;          // per task; 0 means unspecified
};

using FarmJson = nlohmann::ordered_json;

/// Turns each path in the words into a parameter of type PATH, so that a farm can put files elsewhere.
FarmJson openjd_template(const FarmCommand& command);
FarmJson openjd_parameter_values(const FarmCommand& command);
FarmJson openjd_asset_references(const FarmCommand& command);

/// Returns absolute paths, sorted and without duplicates.
std::vector<std::string> openjd_input_files(const FarmCommand& command);
/// Counts the tasks of all steps, which are the shares and the steps before and after them.
int openjd_task_count(const FarmCommand& command);

/// Returns objects, lists, texts, numbers and booleans as YAML 1.2 in block style. Texts are in double quotes.
std::string yaml_text(const FarmJson& value);

/// Creates the folder and writes the three files. Throws Error(kUsage), before anything is written, if the job exceeds
/// the specification's limits (host/farm/openjd/openjd_limits.h). Throws Error(kEnvironment).
void write_openjd_bundle(const FarmCommand& command, const std::string& folder);

}  // namespace multum
