// SPDX-License-Identifier: Apache-2.0
// The subcommands of `multum`. Each adds its options to `app` and, when it is chosen, sets *exit_code.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/multum/doctor_checks.h"

namespace multum {

/// Options that every command shares.
struct CommonOptions {
  int threads = 0;  // 0: all cores
  bool verbose = false;
  bool quiet = false;
  bool openjd = false;  // print lines for whoever runs this as a task (tools/multum/openjd_lines.h)
};

/// Applies verbosity and thread count to everything below; to be called before the first OpenCL or image call.
/// Returns the thread count.
int apply(const CommonOptions& options);
void add_common_options(CLI::App& command, CommonOptions& options);

/// Of a long command: a bar on a terminal; under a service, what the worker passes on.
std::unique_ptr<Progress> make_progress(const CommonOptions& options);

/// Does what a command line says and returns its exit code. Throws Error, Cancelled.
int run_command(int argc, char** argv);
/// The same of the words behind the program's name; `callback` hears of the progress. One at a time.
int run_command_heard(const std::vector<std::string>& words, const Progress::Callback& callback);

/// Folders for compiled kernels, as the environment names them.
KernelCacheFolders kernel_cache_folders();

/// multum-view lies beside multum, in the build folder and when installed; else the one in PATH.
std::string find_viewer();

void add_bake_command(CLI::App& app, int* exit_code);
void add_export_command(CLI::App& app, int* exit_code);
void add_gltf_command(CLI::App& app, int* exit_code);
/// A page that shows lobes in a browser.
void add_look_command(CLI::App& app, int* exit_code);
void add_devices_command(CLI::App& app, int* exit_code);
/// Checks the machine.
void add_doctor_command(CLI::App& app, int* exit_code);
void add_info_command(CLI::App& app, int* exit_code);
/// The shading of lobes in other languages.
void add_shaders_command(CLI::App& app, int* exit_code);
void add_selftest_command(CLI::App& app, int* exit_code);
void add_tradeoff_command(CLI::App& app, int* exit_code);
void add_verify_command(CLI::App& app, int* exit_code);
void add_testmap_command(CLI::App& app, int* exit_code);
void add_plan_command(CLI::App& app, int* exit_code);
/// mip, reflectance, lod.
void add_pyramid_commands(CLI::App& app, int* exit_code);
/// The table of all parameters.
void add_parameters_command(CLI::App& app, int* exit_code);
void add_materials_command(CLI::App& app, int* exit_code);

// The farm: tools/multum/farm, or no_farm.cpp in a build without it.

/// Throws Error(kUsage) where a command line's words are none of this program.
using CheckWords = void (*)(const std::vector<std::string>& words);

/// Hands the farm the jobs of multum's commands. Once, before any command.
void register_jobs();
/// openjd, serve, the clients of a service, and a line for each in the text of `app` itself.
void add_farm_commands(CLI::App& app, int* exit_code, CheckWords check_words);
/// Asks the service at `server` (empty: the usual one) whether it is well; nothing in a build without the farm.
DoctorFindings service_findings(const std::string& server);
/// The schemas of docs/reference/openapi.json that the program says, by name (host/farm/service/http/job_schemas.h).
nlohmann::ordered_json job_schemas();

}  // namespace multum
