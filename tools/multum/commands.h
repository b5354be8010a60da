// SPDX-License-Identifier: Apache-2.0
// Declares the subcommands of `multum`. Each function adds a subcommand to `app`. When the subcommand runs, it sets
// *exit_code.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/multum/doctor_checks.h"

namespace multum {

/// The options that most commands share.
struct CommonOptions {
  int threads = 0;  // 0 means all cores
  bool verbose = false;
  bool quiet = false;
  bool openjd = false;  // print progress lines for the agent of a render farm (tools/multum/openjd_lines.h)
  bool json = false;    // print the result as one JSON document on stdout, and nothing else there
};

/// Sets the verbosity and the thread count of the process, and returns the thread count. Call this function before the
/// first OpenCL or image call.
int apply(const CommonOptions& options);
void add_common_options(CLI::App& command, CommonOptions& options);

/// Returns the progress of a long command, which is a bar on a terminal or the callback of a worker.
std::unique_ptr<Progress> make_progress(const CommonOptions& options);

/// Runs a command line and returns its exit code. Throws Error and Cancelled.
int run_command(int argc, char** argv);
/// Runs a command line without the program's name. `callback` receives the progress. Only one call may run at a time.
int run_command_heard(const std::vector<std::string>& words, const Progress::Callback& callback);

/// Returns the value of an environment variable, or null.
const char* environment_variable(const char* name);

void add_bake_command(CLI::App& app, int* exit_code);
void add_export_command(CLI::App& app, int* exit_code);
void add_gltf_command(CLI::App& app, int* exit_code);
/// Adds check, which tells whether maps gain from multum.
void add_check_command(CLI::App& app, int* exit_code);
/// Adds look, which writes a page that shows lobes in a browser.
void add_look_command(CLI::App& app, int* exit_code);
void add_devices_command(CLI::App& app, int* exit_code);
/// Adds doctor, which checks the machine.
void add_doctor_command(CLI::App& app, int* exit_code);
void add_info_command(CLI::App& app, int* exit_code);
/// Adds shaders, which writes the shading of lobes in several languages.
void add_shaders_command(CLI::App& app, int* exit_code);
void add_selftest_command(CLI::App& app, int* exit_code);
void add_tradeoff_command(CLI::App& app, int* exit_code);
void add_verify_command(CLI::App& app, int* exit_code);
void add_testmap_command(CLI::App& app, int* exit_code);
void add_plan_command(CLI::App& app, int* exit_code);
/// mip, reflectance, lod.
void add_pyramid_commands(CLI::App& app, int* exit_code);
/// Adds parameters, which prints the table of all parameters.
void add_parameters_command(CLI::App& app, int* exit_code);
/// completion, man.
void add_help_commands(CLI::App& app, int* exit_code);
void add_materials_command(CLI::App& app, int* exit_code);

// The commands of the farm are in tools/multum/farm. A build without the farm uses no_farm.cpp instead.

/// Throws Error(kUsage) if the words are not a valid command line of this program.
using CheckWords = void (*)(const std::vector<std::string>& words);

/// Registers the job types of the farm. Call this function once, before any command.
void register_jobs();
/// Adds serve, jobs and openjd. Also refuses old names of commands.
void add_farm_commands(CLI::App& app, int* exit_code, CheckWords check_words);
/// Asks the service at `server`, or at the default address if `server` is empty, whether it works. In a build without
/// the farm, returns no findings.
DoctorFindings service_findings(const std::string& server);
/// Returns the schemas of docs/reference/openapi.json that are made from tables of the program, by name
/// (host/farm/service/http/job_schemas.h).
nlohmann::ordered_json job_schemas();

}  // namespace multum
