// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/program_cache.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <iterator>
#include <optional>
#include <vector>

#include "host/formats/opencl/cl_error.h"
#include "host/formats/opencl/device_state.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/interrupt.h"
#include "kernels/kernel_sources.h"

namespace multum {
namespace {

std::string g_cache_folder;

// Binaries end with the SHA-256 of the preceding bytes, so that a driver never gets a file that a full disk has
// truncated.
constexpr std::size_t kDigestSize = 64;

// Builds a program in the state's context, or in another context of its device.
cl::Program build_from_source(const DeviceState& state, const cl::Context& context, const std::string& file,
                              const std::string& source, const std::string& options) {
  cl_int status = CL_SUCCESS;
  cl::Program program(context, source, false, &status);
  check_cl(status, file + ".cl: clCreateProgramWithSource");
  status = program.build(state.device, options.c_str());
  if (status == CL_SUCCESS) return program;
  // When the program gets a signal, LLVM (PoCL's compiler) deletes the files that it is writing.
  if (is_interrupted()) throw Cancelled();
  throw Error(ErrorCode::kEnvironment,
              fmt::format("{}.cl does not build on {} with {}: {}\n{}", file, state.info.name, options,
                          cl_error_name(status), program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(state.device)));
}

// Returns nothing if there is no binary, or if the driver rejects the binary as damaged or foreign.
std::optional<cl::Program> build_from_binary(const DeviceState& state, const std::string& bytes,
                                             const std::string& options) {
  if (bytes.empty()) return std::nullopt;
  std::vector<cl_int> binary_status;
  cl_int status = CL_SUCCESS;
  cl::Program program(state.context, {state.device}, cl::Program::Binaries{{bytes.begin(), bytes.end()}},
                      &binary_status, &status);
  if (status != CL_SUCCESS || binary_status.at(0) != CL_SUCCESS) return std::nullopt;
  if (program.build(state.device, options.c_str()) != CL_SUCCESS) return std::nullopt;
  return program;
}

// Returns an empty string if the driver has no binary.
std::string binary_of(const cl::Program& program) {
  const cl::Program::Binaries binaries = program.getInfo<CL_PROGRAM_BINARIES>();
  return binaries.empty() ? "" : std::string(binaries[0].begin(), binaries[0].end());
}

// Returns an empty string if there is no usable binary.
std::string read_binary(const std::string& path) {
  std::string bytes;
  try {
    RegularFileStream in(path);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  } catch (const Error& error) {  // the path is a folder or FIFO; save_binary() reports that it cannot be written
    log_verbose(std::string("program cache: ") + error.what());
    return {};
  }
  if (bytes.size() <= kDigestSize) return {};
  const std::string digest = bytes.substr(bytes.size() - kDigestSize);
  bytes.resize(bytes.size() - kDigestSize);
  if (hash_text(bytes) == digest) return bytes;
  log_verbose("program cache: " + path + " is damaged, so it is built again");
  return {};
}

// If a binary cannot be stored, the next run must build it again, but this run must not fail.
void save_binary(const std::string& bytes, const std::string& path) {
  if (bytes.empty()) return;
  try {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    write_text_file(path, bytes + hash_text(bytes));
  } catch (const std::exception& error) {
    log_verbose(std::string("program cache: ") + error.what());
  }
}

struct Source {
  std::string text;
  std::string path;  // path of the binary
};

Source source_of(const DeviceState& state, const std::string& file, const std::string& options) {
  const auto found = kernel_sources().find(file + ".cl");
  MULTUM_CHECK(found != kernel_sources().end());
  Source source{edited_source(found->second, file, state.edits), ""};
  if (g_cache_folder.empty()) return source;
  ContentHash key;
  for (std::string_view part :
       {std::string_view(source.text), std::string_view(options), std::string_view(state.info.name),
        std::string_view(state.info.platform), std::string_view(state.info.driver)}) {
    key.update(part);
    key.update("\n");
  }
  source.path = g_cache_folder + "/" + file + "-" + key.finish().substr(0, 32) + ".clbin";
  return source;
}

// Prints a message once per device, because a first run takes seconds longer than later ones.
void tell_of_building(DeviceState& state) {
  if (state.told_of_building) return;
  state.told_of_building = true;
  log_info("compiling kernels for " + state.info.name + "; later runs read them from " + g_cache_folder);
}

std::string build_binary(const DeviceState& state, const cl::Context& context, const std::string& file,
                         const Source& source, const std::string& options) {
  const std::string bytes = binary_of(build_from_source(state, context, file, source.text, options));
  save_binary(bytes, source.path);
  return bytes;
}

cl::Context make_context(const cl::Device& device) {
  cl_int status = CL_SUCCESS;
  cl::Context context(device, nullptr, nullptr, nullptr, &status);
  check_cl(status, "clCreateContext");
  return context;
}

}  // namespace

void set_program_cache_folder(const std::string& folder) { g_cache_folder = folder; }

std::string program_key(const DeviceState& state, const std::string& file, const std::string& options) {
  std::string key = file + " " + options;
  for (const SourceEdit& edit : state.edits)
    if (edit.file == file) key += "\n" + edit.text + "\n" + edit.replacement;
  return key;
}

void prepare_program(DeviceState& state, const std::string& file, const std::string& options) {
  const std::string key = program_key(state, file, options);
  if (g_cache_folder.empty() || state.programs.count(key) != 0 || state.builds.has(key)) return;
  const Source source = source_of(state, file, options);
  std::error_code ignored;
  if (std::filesystem::exists(source.path, ignored)) return;  // load_program() reads it, or builds it again
  tell_of_building(state);
  // Every thread has its own context. PoCL builds only one program at a time per context. PoCL reads its function
  // library once per context, which takes half as long as building a small program. The state exists longer than its
  // builds, which read only its constant members.
  state.builds.add(key, [&state, file, source, options](cl::Context& context) {
    if (context() == nullptr) context = make_context(state.device);
    return build_binary(state, context, file, source, options);
  });
}

cl::Program load_program(DeviceState& state, const std::string& file, const std::string& options) {
  const std::optional<std::string> prepared = state.builds.take(program_key(state, file, options));
  if (prepared)
    if (const auto program = build_from_binary(state, *prepared, options)) return *program;
  const Source source = source_of(state, file, options);
  if (!prepared && !g_cache_folder.empty()) {
    if (const auto program = build_from_binary(state, read_binary(source.path), options)) {
      log_verbose("program cache: " + file + " loaded");
      return *program;
    }
    ++state.unprepared_count;
    log_verbose("program cache: " + file + " is being built while its caller waits");
    tell_of_building(state);
    // Loads even a new program from its binary, so that the first run behaves in the same way as later runs.
    const std::string bytes = build_binary(state, state.context, file, source, options);
    if (const auto program = build_from_binary(state, bytes, options)) return *program;
  }
  return build_from_source(state, state.context, file, source.text, options);
}

const std::string& kernel_sources_hash() {
  static const std::string hash = [] {
    std::string all;
    for (const auto& [name, source] : kernel_sources()) all += source;
    return hash_text(all);
  }();
  return hash;
}

}  // namespace multum
