// SPDX-License-Identifier: Apache-2.0
// Implements multum doctor, which checks the machine, reports problems, and says how to solve them.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/commands.h"
#include "tools/multum/doctor_checks.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct DoctorOptions {
  std::string device, server;
  CommonOptions common;
};

void append(DoctorFindings& findings, const DoctorFindings& more) {
  findings.insert(findings.end(), more.begin(), more.end());
}

// Runs the checks that need files, in a temporary folder that is removed afterwards.
DoctorFindings file_findings(const DoctorSettings& settings) {
  std::error_code error;
  const std::string temporary = std::filesystem::temp_directory_path(error).string();
  try {
    const std::unique_ptr<WorkFolder> folder = WorkFolder::make(temporary);
    DoctorFindings findings = trial_findings(settings, folder->path());
    append(findings, program_findings(folder->path()));
    return findings;
  } catch (const Error& failure) {
    return {{DoctorState::kFailure, "bake", std::string("not tried: ") + failure.what(),
             "Set TMPDIR to a folder that can be written."}};
  }
}

nlohmann::ordered_json findings_json(const DoctorFindings& findings) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const DoctorFinding& f : findings)
    rows.push_back({{"area", f.area}, {"state", doctor_state_name(f.state)}, {"found", f.found}, {"advice", f.advice}});
  return {{"software", std::string("multum ") + MULTUM_VERSION}, {"findings", rows}};
}

std::string findings_text(const DoctorFindings& findings) {
  std::string text;
  for (const DoctorFinding& f : findings) {
    text += fmt::format("{:<8} {:<9} {}\n", doctor_state_name(f.state), f.area, f.found);
    if (!f.advice.empty()) text += fmt::format("{:<8} {:<9} {}\n", "", "", f.advice);
  }
  return text;
}

int run_doctor(const DoctorOptions& options) {
  apply(options.common);
  const DoctorSettings settings{options.device, find_viewer(), kernel_cache_folders(environment_variable)};
  DoctorFindings findings = machine_findings();
  append(findings, device_findings(settings));
  append(findings, cache_findings(settings.caches));
  append(findings, decoder_findings());
  append(findings, disk_findings());
  append(findings, file_findings(settings));
  append(findings, service_findings(options.server));
  std::size_t failures = 0, warnings = 0;
  for (const DoctorFinding& f : findings) {
    failures += f.state == DoctorState::kFailure ? 1 : 0;
    warnings += f.state == DoctorState::kWarning ? 1 : 0;
  }
  if (options.common.json) print_json(findings_json(findings));
  else write_shown(stdout, findings_text(findings) + fmt::format("\n{} failures, {} warnings\n", failures, warnings));
  if (failures > 0)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("this machine fails {} checks; follow the advice under each failure", failures));
  return 0;
}

}  // namespace

void add_doctor_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* command = app.add_subcommand("doctor", "check this machine, report problems, and suggest solutions");
  command->add_option("--device", options->device,
                      "check this OpenCL device: its number in `multum devices`, or part of its name");
  command->add_option("--server", options->server,
                      "ask this service: http://HOST:PORT or unix:PATH (default: $MULTUM_SERVER, else "
                      "http://127.0.0.1:8470)");
  add_common_options(*command, options->common);
  command->callback([options, exit_code] { *exit_code = run_doctor(*options); });
}

}  // namespace multum
