// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/doctor_checks.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>

#include "host/bakes/scene/plan_text.h"
#include "host/delivery/export/uastc/uastc_encoder.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/sandbox/decoding_child.h"
#include "host/foundation/sandbox/read_only_process.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
constexpr std::uint64_t kMemoryLow = kGiB;  // a bake of 4096 x 4096 texels needs a third of this
constexpr std::uint64_t kDiskLow = kGiB;    // a baked map of 4096 x 4096 texels is about 200 MiB large
// A trial takes a second. If kernels must be compiled first, it takes up to a minute.
constexpr std::chrono::minutes kTrialTime{5};

struct FolderSize {
  std::uint64_t bytes = 0;
  std::size_t files = 0;
};

FolderSize folder_size(const std::string& folder) {
  FolderSize size;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, error), end;
       !error && at != end; at.increment(error)) {
    std::error_code ignored;
    if (!at->is_regular_file(ignored) || at->is_symlink(ignored)) continue;
    const std::uintmax_t bytes = at->file_size(ignored);
    if (!ignored) size.bytes += bytes;
    ++size.files;
  }
  return size;
}

bool can_write(const fs::path& folder) { return access(folder.c_str(), W_OK | X_OK) == 0; }

DoctorFinding cache_finding(const std::string& folder, const std::string& what, const std::string& variable) {
  if (folder.empty())
    return {DoctorState::kWarning, "cache", fmt::format("{}: switched off, so kernels are compiled in every run", what),
            fmt::format("Unset {}, or set it to a folder that can be written.", variable)};
  // If a folder is not writable, it is replaced with a private folder when a device is opened (kernel_caches.h).
  const char* const used = std::getenv(variable.c_str());
  if (used != nullptr && used != folder)
    return {DoctorState::kWarning, "cache",
            fmt::format("{}: {} cannot be written, so kernels are compiled in every run", what, folder),
            fmt::format("Set {} to a folder that can be written.", variable)};
  const FolderSize size = folder_size(folder);
  return {DoctorState::kFine, "cache",
          fmt::format("{}: {}, {} in {} files", what, folder, bytes_text(static_cast<double>(size.bytes)), size.files),
          ""};
}

DoctorFinding disk_finding(const std::string& folder, const std::string& what, const std::string& advice) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error) return {DoctorState::kFailure, "disk", fmt::format("{}: {}: {}", what, folder, error.message()), advice};
  const std::string found =
      fmt::format("{}: {}, {} free", what, folder, bytes_text(static_cast<double>(space.available)));
  if (!can_write(folder)) return {DoctorState::kWarning, "disk", found + ", cannot be written", advice};
  if (space.available < kDiskLow) return {DoctorState::kWarning, "disk", found, advice};
  return {DoctorState::kFine, "disk", found, ""};
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \n\r");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.find_last_of('\n', end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1, end - (begin == std::string::npos ? -1 : begin));
}

// Returns one line with the reason why a child process failed, or an empty string if it succeeded.
std::string failure_of(const ChildResult& child) {
  if (child.is_over_time) return "it took longer than five minutes";
  if (child.signal != 0) return fmt::format("it was terminated by signal {}", child.signal);
  if (child.exit_code == 0) return "";
  const std::string line = last_line(child.output);
  return line.empty() ? fmt::format("exit code {}", child.exit_code) : line;
}

ChildResult run_trial(const std::vector<std::string>& command) {
  ChildLimits limits;
  limits.time_max = kTrialTime;
  return run_child(command, limits);
}

DoctorFinding context_finding(const DoctorSettings& settings, const std::string& folder, const std::string& context) {
  const std::string report = folder + "/" + context + ".json";
  const std::string package = context == "egl" ? "libegl1 and libegl-mesa0" : "libosmesa6";
  std::string failure;
  try {
    failure = failure_of(run_trial({settings.viewer, folder + "/trial.ndf.exr", "-o", folder + "/" + context + ".png",
                                    "--size", "32x32", "--context", context, "--report", report}));
  } catch (const Error& error) {
    failure = error.what();
  }
  if (!failure.empty())
    return {DoctorState::kWarning, "GL", fmt::format("multum-view --context {}: {}", context, failure),
            fmt::format("Install the driver (Debian packages {}).", package)};
  const std::optional<std::string> text = json_of_file(report, StandardInput::kRefused);
  const nlohmann::json json = nlohmann::json::parse(text.value_or(""), nullptr, false);
  return {DoctorState::kFine, "GL",
          json.is_object() ? json.value("context", context + ": drew a picture") : context + ": drew a picture", ""};
}

DoctorFindings context_findings(const DoctorSettings& settings, const std::string& folder) {
  DoctorFindings findings;
  for (const char* const context : {"egl", "osmesa"}) findings.push_back(context_finding(settings, folder, context));
  const bool has_any = std::any_of(findings.begin(), findings.end(),
                                   [](const DoctorFinding& f) { return f.state == DoctorState::kFine; });
  for (DoctorFinding& finding : findings)
    if (!has_any) finding.state = DoctorState::kFailure;
  return findings;
}

}  // namespace

const char* doctor_state_name(DoctorState state) {
  switch (state) {
    case DoctorState::kFine: return "ok";
    case DoctorState::kAbsent: return "absent";
    case DoctorState::kWarning: return "warning";
    case DoctorState::kFailure: return "failure";
  }
  return "";
}

DoctorFindings machine_findings() {
  const std::uint64_t memory = machine_memory_bytes();
  const std::string found =
      fmt::format("{} processors, {} of memory", processor_count(), bytes_text(static_cast<double>(memory)));
  if (memory >= kMemoryLow) return {{DoctorState::kFine, "machine", found, ""}};
  return {{DoctorState::kWarning, "machine", found,
           "Bakes of large maps will use a scratch file. Raise the limit of the container, or `ulimit -v`."}};
}

DoctorFindings device_findings(const DoctorSettings& settings) {
  const std::vector<DeviceInfo> devices = list_devices();
  if (devices.empty()) {
    const std::string& cache = pocl_cache_failure();
    return {{DoctorState::kFailure, "OpenCL", cache.empty() ? "no device" : "no device: " + cache,
             cache.empty()
                 ? "Install a driver, such as PoCL (Debian package pocl-opencl-icd). Then run `multum devices`."
                 : "Set POCL_CACHE_DIR to a folder that can be written."}};
  }
  DoctorFindings findings;
  for (const DeviceInfo& d : devices)
    findings.push_back({DoctorState::kFine, "OpenCL",
                        fmt::format("device {}: {}, {}, driver {}, {}", d.index, d.name, d.platform, d.driver,
                                    bytes_text(static_cast<double>(d.memory_bytes))),
                        ""});
  if (!choose_device(devices, settings.device))
    findings.push_back({DoctorState::kFailure, "OpenCL", fmt::format("--device {}: no such device", settings.device),
                        "Give a device number from `multum devices`, or part of a device name."});
  return findings;
}

DoctorFindings cache_findings(const KernelCacheFolders& folders) {
  return {cache_finding(folders.programs, "compiled kernels", "MULTUM_CACHE_DIR"),
          cache_finding(folders.pocl, "PoCL", "POCL_CACHE_DIR")};
}

DoctorFindings decoder_findings() {
  const std::string program = decoder_beside_this_program();
  if (access(program.c_str(), X_OK) != 0)
    return {{DoctorState::kFailure, "decoder", fmt::format("{}: is missing, so images cannot be read", program),
             "Install multum-decode next to multum; both must come from the same build."}};
  if (!can_confine_to_reading())
    return {{DoctorState::kWarning, "decoder",
             "files are decoded in a child process with limited memory and time, but this kernel cannot confine it",
             "Read untrusted files only where the kernel has seccomp filters."}};
  return {{DoctorState::kFine, "decoder", "files are decoded in a child process that can only read files", ""}};
}

DoctorFindings disk_findings() {
  std::error_code error;
  const fs::path current = fs::current_path(error);
  const fs::path temporary = fs::temp_directory_path(error);
  DoctorFindings findings = {
      disk_finding(current.string(), "current folder", "Write to another folder (`--output`, `--scratch`).")};
  const char* const named = std::getenv("TMPDIR");
  findings.push_back(disk_finding(temporary.empty() && named != nullptr ? named : temporary.string(),
                                  "temporary folder", "Set TMPDIR to a folder that can be written."));
  return findings;
}

DoctorFindings trial_findings(const DoctorSettings& settings, const std::string& folder) {
  const std::string program = own_program();
  const ChildResult map = run_trial({program, "testmap", folder + "/trial", "--size", "32"});
  std::vector<std::string> bake = {
      program, "bake", folder + "/trial_normal.png", "-o", folder + "/trial.ndf.exr", "--green", "up", "--quiet"};
  if (!settings.device.empty()) bake.insert(bake.end(), {"--device", settings.device});
  std::string failure = failure_of(map);
  double seconds = 0;
  if (failure.empty()) {
    const ChildResult baked = run_trial(bake);
    failure = failure_of(baked);
    seconds = baked.usage.wall_seconds;
  }
  if (!failure.empty())
    return {{DoctorState::kFailure, "bake", "a map of 32 x 32 texels: " + failure,
             "Run `multum selftest`, which names the kernels that this driver computes wrongly."},
            {DoctorState::kAbsent, "GL", "not tested, because no map was baked", ""}};
  DoctorFindings findings = {
      {DoctorState::kFine, "bake", fmt::format("a map of 32 x 32 texels, in {:.1f} s", seconds), ""}};
  const DoctorFindings contexts = context_findings(settings, folder);
  findings.insert(findings.end(), contexts.begin(), contexts.end());
  return findings;
}

DoctorFindings program_findings(const std::string& folder) {
  DoctorFindings findings;
  try {
    UastcSettings settings;
    settings.option = "--format";
    settings.folder = folder;
    check_uastc_encoder(settings);
    findings.push_back(
        {DoctorState::kFine, "programs", "Node.js and ktx2-encoder are installed, so UASTC textures can be made", ""});
  } catch (const Error& error) {
    findings.push_back({DoctorState::kAbsent, "programs", error.what(), "Needed only for UASTC textures."});
  }
  bool has_ffmpeg = false;
  try {
    has_ffmpeg = run_child({"ffmpeg", "-version"}).exit_code == 0;
  } catch (const Error&) {
    has_ffmpeg = false;
  }
  if (has_ffmpeg) findings.push_back({DoctorState::kFine, "programs", "ffmpeg: pages contain videos", ""});
  else
    findings.push_back({DoctorState::kAbsent, "programs", "ffmpeg: not installed",
                        "Needed only for videos on the pages of `multum export --page`."});
  return findings;
}

}  // namespace multum
