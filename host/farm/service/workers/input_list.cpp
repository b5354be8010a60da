// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/workers/input_list.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/sandbox/confinement.h"

namespace multum {
namespace {

using Json = nlohmann::json;

constexpr auto kTimeMax = std::chrono::seconds(10);
constexpr std::uint64_t kMemoryMax = std::uint64_t{512} << 20;
constexpr std::size_t kOutputMax = 16 << 20;  // in bytes; limited because the daemon reads the output

// Returns the last line, and skips warnings before it.
std::string last_line(std::string output) {
  while (output.ends_with('\n')) output.pop_back();
  return output.substr(output.rfind('\n') + 1);
}

std::string message_of(const std::string& output) {
  const std::string line = last_line(output);
  return line.starts_with("multum: ") ? line.substr(8) : line;
}

ErrorCode error_code_of(int exit_code_found) {
  for (const ErrorCode code : {ErrorCode::kUsage, ErrorCode::kInput, ErrorCode::kEnvironment})
    if (exit_code(code) == exit_code_found) return code;
  return ErrorCode::kInput;
}

}  // namespace

InputList list_inputs_in_child(const JobType& type, const Json& parameters, const PathRoots& roots) {
  if (type.files_of_input == nullptr) return {input_files(type, parameters), input_identity(type, parameters)};
  const std::string file = path_of_text(parameters.at(type.input).get<std::string>());
  std::vector<std::string> command = {own_program(), "inputs", "--type=" + type.name,
                                      "--parameters=" + parameters.dump()};
  for (const std::string& root : roots.roots()) command.push_back("--root=" + root);
  ChildLimits limits;
  limits.time_max = kTimeMax;
  limits.memory_max = kMemoryMax;
  limits.output_max = kOutputMax;
  const ChildResult child = run_child(command, limits);
  const bool is_out_of_memory = child.exit_code != 0 && message_of(child.output) == "out of memory";
  if (child.is_over_time || child.signal != 0 || is_out_of_memory)
    throw Error(ErrorCode::kInput, fmt::format("{}: cannot be read within {} s and {} MiB of memory", file,
                                               kTimeMax.count(), kMemoryMax >> 20));
  if (child.exit_code != 0) throw Error(error_code_of(child.exit_code), message_of(child.output));
  const Json list = Json::parse(last_line(child.output), nullptr, false);
  if (!list.is_object())
    throw Error(ErrorCode::kEnvironment, file + ": the list of files that it names could not be created");
  return {paths_of_texts(list.at("files").get<std::vector<std::string>>()), list.at("identity").get<std::string>()};
}

void print_input_list(const std::string& type_name, const std::string& parameters_text,
                      const std::vector<std::string>& roots, Confinement allowed) {
  allowed.readable.insert(allowed.readable.end(), roots.begin(), roots.end());
  allowed.writable.clear();
  confine_this_thread(allowed);
  const JobType& type = find_job_type(type_name);
  const Json parameters = Json::parse(parameters_text, nullptr, false);
  check_parameters(type, parameters);
  const std::string text =
      Json{{"files", texts_of_paths(input_files(type, parameters))}, {"identity", input_identity(type, parameters)}}
          .dump();
  std::puts(text.c_str());
}

}  // namespace multum
