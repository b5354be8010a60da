// SPDX-License-Identifier: Apache-2.0
// Implements multum check, which tells in seconds whether maps and models gain from multum.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/delivery/check/check_job.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"
#include "host/foundation/parameters/check_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/check/verdict_line.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct CheckOptions {
  CommonOptions common;
  CheckJob job;
  ParameterValues values{check_parameters()};
  std::vector<std::string> inputs;
};

struct CheckResults {
  std::vector<GainVerdict> verdicts;
  std::size_t other_files = 0;  // files of folders that are not normal maps
  int code = 0;                 // exit code of the first failure
};

// Checks one file. Files of a folder that are not normal maps are only counted.
void check_one(const CheckOptions& o, const std::string& file, bool is_in_folder, Device& device,
               CheckResults& results) {
  CheckJob job = o.job;
  job.input = file;
  job.only_normals = is_in_folder && !o.values.has("bumpformat");
  std::vector<GainVerdict> found;
  try {
    const auto progress = make_progress(o.common);
    found = check_file(job, device, progress.get());
  } catch (...) {
    const Error error = caught_error(file);
    if (!is_in_folder || error.code() != ErrorCode::kInput) {
      if (o.inputs.size() == 1 && !is_in_folder) throw;
      print_shown(stderr, "multum: %s\n", error.what());
      if (results.code == 0) results.code = exit_code(error.code());
      return;
    }
    ++results.other_files;
    if (prints_text(o.common) && o.common.verbose) print_shown(stdout, "not checked: %s\n", error.what());
    return;
  }
  for (GainVerdict& verdict : found) {
    print_verdict(verdict.name, verdict, o.common);
    results.verdicts.push_back(std::move(verdict));
  }
}

int run_check(CheckOptions& o) {
  o.job.threads = apply(o.common);
  keep_freed_memory();
  apply(o.values, o.job);
  Device device = Device::when_needed({o.values.text("device").value_or("")});
  CheckResults results;
  for (const std::string& input : o.inputs) {
    std::error_code error;
    if (!std::filesystem::is_directory(input, error)) {
      check_one(o, input, false, device, results);
      continue;
    }
    const std::vector<std::string> files = files_to_check(input);
    if (files.empty())
      throw Error(ErrorCode::kInput, input + ": contains no images or models; expected normal maps, *.glb or *.gltf");
    for (const std::string& file : files) check_one(o, file, true, device, results);
  }
  if (results.other_files > 0 && prints_text(o.common))
    print_shown(stdout, "%zu maps; %zu other files are not normal maps (-v names them)\n", results.verdicts.size(),
                results.other_files);
  if (o.common.json) {
    OrderedJson maps = OrderedJson::array();
    for (const GainVerdict& verdict : results.verdicts) maps.push_back(verdict.to_json());
    print_json({{"maps", maps}});
  }
  if (results.code != 0) return results.code;
  const auto least = o.values.number("fail_below");
  for (const GainVerdict& verdict : results.verdicts) {
    if (!least || verdict.measured.empty() || verdict.gain() >= *least) continue;
    print_shown(stderr, "multum: %s: found a gain of %.1f points, expected at least %.1f (--fail-below)\n",
                verdict.name.c_str(), verdict.gain(), *least);
    results.code = exit_code(ErrorCode::kVerification);
  }
  return results.code;
}

}  // namespace

void add_check_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<CheckOptions>();
  CheckOptions& o = *options;
  CLI::App* command =
      app.add_subcommand("check", "tell whether maps gain from multum, from which distance on, and with which form");
  command->footer(
      "Examples:\n"
      "  multum check helmet.glb textures/\n"
      "  multum check bricks_normal.png --tile-size 2 --base-roughness 0.5 -v\n"
      "The errors are estimates from a small part of each map, for pictures of 1080 rows with a field of view of 45\n"
      "degrees. -v lists all errors.");
  command->add_option("inputs", o.inputs, "normal maps, height fields, models (*.glb, *.gltf) or folders of these")
      ->required();
  add_parameter_options(*command, o.values);
  add_common_options(*command, o.common);
  add_decoding_option(*command);
  command->callback([options, exit_code] { *exit_code = run_check(*options); });
}

}  // namespace multum
