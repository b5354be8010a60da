// SPDX-License-Identifier: Apache-2.0
// Runs a command line of `multum` and returns its exit code.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/formats/opencl/kernel_caches.h"
#include "host/formats/opencl/pocl_settings.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/machine.h"
#include "tools/command_line/before_command.h"
#include "tools/command_line/usage_error.h"
#include "tools/multum/commands.h"
#include "tools/multum/fields/field_commands.h"
#include "tools/multum/json_output.h"
#include "tools/multum/openjd_lines.h"

namespace multum {
namespace {

// Returns the progress callback of the command that a worker runs. Only one command runs at a time.
Progress::Callback& listener() {
  static Progress::Callback callback;
  return callback;
}

void check_words(const std::vector<std::string>& words);

// Puts the commands of `add` under a heading in the help text.
void add_group(CLI::App& app, const std::string& heading, const std::function<void()>& add) {
  const std::size_t before = app.get_subcommands({}).size();
  add();
  const std::vector<CLI::App*> commands = app.get_subcommands([](CLI::App*) { return true; });
  for (std::size_t i = before; i < commands.size(); ++i)
    if (!commands[i]->get_group().empty()) commands[i]->group(heading);
}

void add_commands(CLI::App& app, int* exit_code) {
  add_group(app, "Bake", [&] {
    add_bake_command(app, exit_code);
    add_plan_command(app, exit_code);
    add_tradeoff_command(app, exit_code);
    add_info_command(app, exit_code);
    add_verify_command(app, exit_code);
    add_materials_command(app, exit_code);
    add_testmap_command(app, exit_code);
    add_pyramid_commands(app, exit_code);
  });
  add_group(app, "Deliver", [&] {
    add_export_command(app, exit_code);
    add_gltf_command(app, exit_code);
    add_check_command(app, exit_code);
    add_look_command(app, exit_code);
    add_shaders_command(app, exit_code);
  });
  add_group(app, "Fields", [&] { add_field_commands(app, exit_code); });
  add_group(app, "Service", [&] { add_farm_commands(app, exit_code, check_words); });
  add_group(app, "Machine", [&] {
    add_doctor_command(app, exit_code);
    add_devices_command(app, exit_code);
    add_selftest_command(app, exit_code);
    add_parameters_command(app, exit_code);
    add_help_commands(app, exit_code);
  });
}

// Parses the words of a command without running it. Throws Error(kUsage) for a wrong command line.
void check_words(const std::vector<std::string>& words) {
  CLI::App app("", "multum");
  app.require_subcommand(1);
  int ignored = 0;
  add_commands(app, &ignored);
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) command->callback([] {});
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::kUsage, words.front() + ": " + error.what());
  }
}

}  // namespace

int run_command(int argc, char** argv) {
  CLI::App app(
      "multum bakes normal maps into mip pyramids that look right at every distance. A texel holds the\n"
      "distribution of the normals that it covers, not their average.\n\n"
      "  multum bake bricks_normal.png -o bricks.ndf.exr     bake a map; print findings and the measured error\n"
      "  multum bake --manifest maps.toml --check            bake the changed maps of a project and list them\n"
      "  multum bake scene.toml -o baked                     bake only what a scene shows; multum plan lists it\n"
      "  multum export bricks_normal.png -o bricks           write normal and roughness mips for engines\n"
      "  multum gltf helmet.glb -o helmet_mips.glb           give the textures of a model better mips\n"
      "  multum look bricks.ndf.exr                          show baked lobes in the browser\n"
      "  multum tradeoff bricks_normal.png -o costs.html     compare settings by error, time and memory\n"
      "  multum-view bricks.ndf.exr -o frame.png             render a baked file\n"
      "  multum selftest                                     check the OpenCL driver of this machine",
      "multum");
  app.set_version_flag("--version", std::string("multum ") + MULTUM_VERSION);
  app.require_subcommand(1);
  app.failure_message(usage_error);
  int exit_code = 0;
  add_commands(app, &exit_code);
  prepare_commands(app);
  set_kernel_caches(kernel_cache_folders(environment_variable));
  const NewFolders new_folders;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return print_parse_error(app, error);
  } catch (const std::exception& error) {
    if (has_openjd_lines()) print_openjd_failure(error.what());
    throw;
  }
  if (has_openjd_lines() && exit_code == 0) print_openjd_success();
  else if (has_openjd_lines()) print_openjd_failure("exit code " + std::to_string(exit_code) + "; stderr says why");
  // A command has succeeded only if its results have been written to stdout. If the disk is full or the pipe is closed,
  // the exit code must not be 0.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw Error(ErrorCode::kEnvironment, "standard output cannot be written");
  return exit_code;
}

int run_command_heard(const std::vector<std::string>& words, const Progress::Callback& callback) {
  listener() = callback;
  std::string program = "multum";
  std::vector<std::string> kept = words;
  std::vector<char*> argv = {program.data()};
  for (std::string& word : kept) argv.push_back(word.data());
  const int count = static_cast<int>(argv.size());
  argv.push_back(nullptr);
  return run_command(count, argv.data());
}

const char* environment_variable(const char* name) { return std::getenv(name); }

std::unique_ptr<Progress> make_progress(const CommonOptions& options) {
  if (listener()) return std::make_unique<Progress>(listener());
  return options.openjd ? make_openjd_progress() : make_terminal_progress(!options.quiet);
}

int apply(const CommonOptions& options) {
  set_log_level(options.quiet ? LogLevel::kQuiet : options.verbose ? LogLevel::kVerbose : LogLevel::kNormal);
  if (options.openjd) begin_openjd_lines();
  const int threads = options.threads > 0 ? options.threads : processor_count();
  set_pocl_threads(threads);
  return threads;
}

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_option("--threads", options.threads, "use this many threads (default: all cores)")
      ->check(CLI::Range(1, 1024))
      ->group(kCommonGroup);
  command.add_flag("-v,--verbose", options.verbose, "also print plans, caches and timings")->group(kCommonGroup);
  command.add_flag("-q,--quiet", options.quiet, "print only errors and results")->group(kCommonGroup);
  CLI::Option* const json = add_json_option(command, options.json);
  command
      .add_flag("--openjd", options.openjd,
                "print progress lines for the agent of a render farm (docs/how-to/clusters.md)")
      ->excludes(json)
      ->group(kCommonGroup);
}

}  // namespace multum
