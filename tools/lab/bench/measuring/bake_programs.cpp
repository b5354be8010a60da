// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/bake_programs.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"
#include "tools/lab/bench/measuring/measured_program.h"

namespace multum::bench {
namespace fs = std::filesystem;

std::string neighbouring_program(const std::string& name) {
  const fs::path folder = program_folder();
  for (const fs::path& program : {folder / name, folder / "test" / name})
    if (fs::exists(program)) return program.string();
  throw Error(ErrorCode::kEnvironment, fmt::format("{}: not found, expected {} in the folder of multum-bench (build "
                                                   "target {})",
                                                   (folder / name).string(), name, name));
}

std::vector<std::string> multum_bake_command(const std::string& map, const std::string& output,
                                             const BakeCommandOptions& options) {
  std::vector<std::string> command = {neighbouring_program("multum"), "bake", map, "-o", output, "--green", "up"};
  if (options.lobes > 0) command.insert(command.end(), {"--lobes", std::to_string(options.lobes)});
  command.insert(command.end(), {"--quiet", "--force"});
  if (options.threads > 0) command.insert(command.end(), {"--threads", std::to_string(options.threads)});
  if (!options.report.empty()) command.insert(command.end(), {"--report", options.report});
  command.insert(command.end(), options.appended.begin(), options.appended.end());
  return command;
}

std::string device_of_report(const std::string& path) {
  std::ifstream in(path);
  return nlohmann::json::parse(in).at("device").get<std::string>();
}

std::vector<std::string> maketx_command(const std::string& map, const std::string& output, int threads) {
  std::vector<std::string> command = {"maketx", "--bumpslopes", "--bumpformat", "normal", map, "-o", output};
  if (threads > 0) command.insert(command.end(), {"--threads", std::to_string(threads)});
  return command;
}

std::string maketx_version() {
  try {
    const std::string output = run_child({"maketx", "--version"}).output;
    return output.substr(0, output.find('\n'));
  } catch (const Error& error) {
    throw Error(ErrorCode::kEnvironment, std::string(error.what()) +
                                             "; expected OpenImageIO's maketx in PATH (Debian package "
                                             "openimageio-tools)");
  }
}

std::string make_map_file(const std::string& prefix, int size, int seed, Progress* progress) {
  const std::string map = prefix + "_normal.png";
  run_to_disk({neighbouring_program("multum"), "testmap", prefix, "--size", std::to_string(size), "--seed",
               std::to_string(seed)},
              map, progress);
  fs::remove(prefix + "_albedo.png");
  return map;
}

std::string make_map_file(const std::string& folder, int size, Progress* progress) {
  constexpr int kDefaultSeed = 7;  // of `multum testmap`
  return make_map_file(folder + "/map", size, kDefaultSeed, progress);
}

}  // namespace multum::bench
