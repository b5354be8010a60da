// SPDX-License-Identifier: Apache-2.0
// Implements multum openjd, which writes another command as a job bundle for render farms.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

#include "host/bakes/bake/bake_batch.h"
#include "host/bakes/manifest/bake_manifest.h"
#include "host/bakes/scene/scene_file.h"
#include "host/delivery/export/batch/export_manifest.h"
#include "host/farm/openjd/openjd_bundle.h"
#include "host/farm/openjd/openjd_limits.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/udim_set.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/work_shard.h"
#include "tools/multum/farm/farm_commands.h"
#include "tools/multum/fields/field_commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// The commands that a farm can run. They need no user input, and they only read and write files.
const std::set<std::string> kCommands = {"bake", "export", "infer", "pack", "mip", "reflectance", "tradeoff"};
const std::set<std::string> kResumable = {"bake", "pack"};
const std::set<std::string> kOutputOptions = {"-o",        "--output", "--report", "--junit",
                                              "--summary", "--page",   "--player", "--debug-picture"};

struct OpenJdOptions {
  CommonOptions common;
  std::string output, name;
  int shards = 0;  // if 0, one share per map, or a single share for an inference
  std::vector<std::string> words;
};

// Splits "--option=value" into two words, so that each path is a word of its own. Writes a set in the current folder as
// ./SET, so that the path contains a folder.
std::vector<std::string> split_words(const std::vector<std::string>& given) {
  std::vector<std::string> words;
  for (const std::string& word : given) {
    const std::size_t equals = word.find('=');
    if (!word.starts_with("--") || equals == std::string::npos) {
      words.push_back(word);
      continue;
    }
    words.push_back(word.substr(0, equals));
    words.push_back(word.substr(equals + 1));
  }
  for (std::string& word : words)
    if (has_udim(word) && word.find('/') == std::string::npos) word.insert(0, "./");
  return words;
}

bool exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}
bool is_folder(const std::string& path) {
  std::error_code ignored;
  return path.ends_with('/') || fs::is_directory(path, ignored);
}
std::string folder_of(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  return parent.empty() ? "." : parent.string();
}

// Returns the path in a word, which is the folder of a set, or the file of FILE:CHANNEL.
std::optional<FarmWord> path_of_word(const std::vector<std::string>& words, std::size_t at) {
  const std::string& word = words[at];
  FarmWord found{at, word, false, at > 0 && kOutputOptions.contains(words[at - 1])};
  if (found.is_output && word != "-") {
    // An output name without an extension is a folder that the command will create.
    found.is_folder = is_folder(word) || fs::path(word).extension().empty();
    if (!has_udim(word)) return found;
  }
  if (has_udim(word) && word.find('/') != std::string::npos) {
    found.path = folder_of(word);
    found.is_folder = true;
    return found;
  }
  if (at == 0 || word.starts_with('-')) return std::nullopt;
  if (!exists(found.path)) found.path = word.substr(0, word.rfind(':'));
  if (found.path.empty() || !exists(found.path)) return std::nullopt;
  found.is_folder = is_folder(found.path);
  return found;
}

// Checks that the input, the first word after the command, exists. Otherwise the job would fail later on a worker.
void check_input_is_there(const std::vector<std::string>& words) {
  if (words.size() < 2 || words[1].starts_with('-') || has_udim(words[1]) || exists(words[1])) return;
  throw Error(ErrorCode::kInput, words[1] + ": does not exist, expected the input of " + words[0]);
}

// The program is one parameter of the job, and each path is another.
void check_path_count(const FarmCommand& command, const std::string& kind) {
  constexpr std::size_t kPathsMax = kOpenJdParametersMax - 1;
  if (command.paths.size() <= kPathsMax) return;
  std::string message = fmt::format(
      "{}: found {} paths, expected at most {}, because each is a parameter of the job and Open Job Description "
      "2023-09 allows {}",
      kind, command.paths.size(), kPathsMax, kOpenJdParametersMax);
  if (kind == "bake" || kind == "export")
    message += fmt::format(
        ". List the maps in a manifest, which has no such limit: multum openjd -o FOLDER {} --manifest "
        "maps.toml (docs/reference/manifests.md)",
        kind);
  throw Error(ErrorCode::kUsage, message);
}

// Throws Error(kUsage) for a bake whose map cannot be divided into shares (docs/how-to/clusters.md).
void check_can_be_divided(const std::vector<std::string>& words) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string& value = i + 1 < words.size() ? words[i + 1] : words[i];
    const bool has_no_bands =
        words[i] == "--refine" || words[i] == "--onto" || words[i] == "--target-error" || words[i] == "--budget-ms" ||
        (words[i] == "--ndf" && (value == "moments" || value == "sh")) || (words[i] == "--lobes" && value == "1");
    if (has_no_bands)
      throw Error(ErrorCode::kUsage,
                  "found --shards of one map with " + words[i] +
                      ", expected a bake of at least two lobes per texel without --refine, --onto, --target-error or "
                      "--budget-ms");
  }
}

struct BakedMaps {
  std::vector<BakeJob> jobs;
  bool is_scene = false, is_manifest = false;
};

BakedMaps maps_of_bake(const std::vector<std::string>& words, const std::vector<FarmWord>& paths) {
  BakeJob pattern;
  std::vector<std::string> maps;
  std::string manifest;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i - 1] == "--manifest") manifest = words[i];
    if (words[i - 1] == "-o" || words[i - 1] == "--output") pattern.output = words[i];
  }
  if (manifest.empty() && pattern.output.empty())
    throw Error(ErrorCode::kUsage, "bake: found no --output, expected --output or --manifest");
  if (!manifest.empty()) {
    BakedMaps baked;
    baked.is_manifest = true;
    for (ManifestMap& map : read_bake_manifest(manifest, pattern)) baked.jobs.push_back(std::move(map.job));
    return baked;
  }
  for (const FarmWord& path : paths)
    if (!path.is_output && !words[path.word - 1].starts_with("--")) maps.push_back(words[path.word]);
  if (maps.empty()) throw Error(ErrorCode::kUsage, "bake: found no existing map, expected a map or --manifest");
  if (maps.size() > 1 || !maps.front().ends_with(".toml")) return {make_bake_jobs(pattern, maps), false};
  BakedMaps scene{{}, true};
  for (SceneMap& map : read_scene(maps.front(), {}).maps) scene.jobs.push_back(std::move(map.job));
  return scene;
}

// Collects the folders to which a command writes, and files that it reads although they are not named in the command
// line.
void collect_files(FarmCommand& command, const BakedMaps& bakes) {
  std::vector<std::string>& files = command.inputs;
  for (const FarmWord& path : command.paths) {
    if (path.is_output) command.output_folders.push_back(path.is_folder ? path.path : folder_of(path.path));
    else if (path.is_folder) command.input_folders.push_back(path.path);
    else files.push_back(path.path);
  }
  for (const BakeJob& job : bakes.jobs) {
    for (const std::string& file : input_files(job)) files.push_back(file);
    if (!job.output.empty()) command.output_folders.push_back(folder_of(job.output));
  }
  const auto add = [&](const std::vector<std::string>& more) { files.insert(files.end(), more.begin(), more.end()); };
  for (std::size_t i = 0; i < files.size() && files[i].ends_with(".toml"); ++i) {
    if (bakes.is_scene) add(scene_files(files[i]));
    if (command.words[0] != "infer") continue;
    add(files_of_inference(files[i]));
    break;
  }
}

// Collects the files and output folders of the exports in a manifest.
void collect_exports(FarmCommand& command) {
  const auto& words = command.words;
  const auto manifest = std::find(words.begin(), words.end(), "--manifest");
  if (words[0] != "export" || manifest == words.end() || manifest + 1 == words.end()) return;
  for (const ManifestExport& map : read_export_manifest(manifest[1], {})) {
    for (const std::string& file : input_files(map.job)) command.inputs.push_back(file);
    command.output_folders.push_back(export_place(map.job.output).folder);
  }
}

FarmCommand farm_command(const OpenJdOptions& o) {
  FarmCommand command;
  command.words = split_words(o.words);
  const std::string kind = command.words.front();
  check_input_is_there(command.words);
  for (std::size_t i = 1; i < command.words.size(); ++i) {
    if (command.words[i] == "--shard" || command.words[i] == "--merge")
      throw Error(ErrorCode::kUsage,
                  "found " + command.words[i] + ", expected --shards N before " + kind + ": each task gets its own");
    if (command.words[i - 1] == "--threads") command.threads = std::stoi(command.words[i]);  // checked before
    if (auto path = path_of_word(command.words, i)) command.paths.push_back(std::move(*path));
  }
  check_path_count(command, kind);
  if (kResumable.contains(kind) &&
      std::find(command.words.begin(), command.words.end(), "--resume") == command.words.end())
    command.words.emplace_back("--resume");
  BakedMaps bakes;
  if (kind == "bake") bakes = maps_of_bake(command.words, command.paths);
  collect_files(command, bakes);
  collect_exports(command);
  const int pieces = std::max(1, static_cast<int>(bakes.jobs.size()));
  // A manifest is divided into maps, even if it lists only one. A single map without a manifest is divided into bands.
  command.is_one_map = bakes.jobs.size() == 1 && !bakes.is_scene && !bakes.is_manifest;
  command.is_merged = bakes.is_scene || kind == "infer";
  command.shards = o.shards > 0 ? o.shards : pieces;
  if (command.is_one_map && command.shards > 1) check_can_be_divided(command.words);
  if (kind == "infer" && command.shards > kMergedSharesMax)
    throw Error(ErrorCode::kUsage,
                fmt::format("--shards is {}, expected at most {}", command.shards, kMergedSharesMax));
  if (command.shards > pieces && !command.is_one_map && kind != "infer")
    throw Error(ErrorCode::kUsage,
                fmt::format("--shards is {}, expected at most {}, the number of maps", command.shards, pieces));
  command.name = o.name.empty() ? "multum " + kind : o.name;
  return command;
}

int run_openjd(const OpenJdOptions& o, CheckWords check_words) {
  apply(o.common);
  if (o.words.empty())
    throw Error(ErrorCode::kUsage, "found no command, expected one, for example: multum openjd -o FOLDER bake ...");
  if (!kCommands.contains(o.words.front()))
    throw Error(ErrorCode::kUsage,
                o.words.front() +
                    " cannot run on a farm, expected one of bake, export, infer, pack, mip, reflectance and tradeoff");
  for (const std::string& word : o.words) check_openjd_text(word, word);
  check_words(o.words);
  const FarmCommand command = farm_command(o);
  check_paths_differ(command.inputs, {o.output});
  write_openjd_bundle(command, o.output);
  const int tasks = openjd_task_count(command);
  const std::size_t files = openjd_input_files(command).size();
  if (o.common.json) print_json({{"output", path_json(o.output)}, {"tasks", tasks}, {"input_files", files}});
  if (prints_text(o.common))
    print_shown(stdout, "%s: written; %d %s, %zu input %s\n", o.output.c_str(), tasks, tasks == 1 ? "task" : "tasks",
                files, files == 1 ? "file" : "files");
  return 0;
}

}  // namespace

void add_openjd_command(CLI::App& app, int* exit_code, CheckWords check_words) {
  auto options = std::make_shared<OpenJdOptions>();
  CLI::App* openjd = app.add_subcommand(
      "openjd", "write another command as an Open Job Description bundle for render farms (docs/how-to/clusters.md)");
  openjd->footer(
      "Examples:\n"
      "  multum openjd -o bundle bake --manifest maps.toml\n"
      "  multum openjd -o bundle --shards 8 bake cliff.png -o cliff.ndf.exr\n"
      "  multum openjd -o bundle --shards 16 infer animation.toml -o inferred");
  openjd->prefix_command();
  openjd->add_option("-o,--output", options->output, "folder to write the bundle to")->required();
  openjd
      ->add_option("--shards", options->shards,
                   "divide the work into this many tasks (default: one per map, or one for an inference), or a single "
                   "map into this many bands (default: not divided)")
      ->check(CLI::Range(1, 999999));
  openjd->add_option("--name", options->name, "set the name of the job (default: the name of the command)");
  add_common_options(*openjd, options->common);
  openjd->callback([openjd, options, exit_code, check_words] {
    options->words = openjd->remaining();
    *exit_code = run_openjd(*options, check_words);
  });
}

}  // namespace multum
