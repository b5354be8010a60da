// SPDX-License-Identifier: Apache-2.0
#include "host/opencl/program_cache.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/opencl/cl_error.h"
#include "host/opencl/device_state.h"
#include "kernels/kernel_sources.h"

namespace multum {
namespace {

std::string g_cache_folder;

// Binaries end with the SHA-256 of what precedes it, so that a file cut short by a full disk is never given to a
// driver.
constexpr std::size_t kDigestSize = 64;

std::string build_log(const DeviceState& state, cl_program program) {
  std::size_t size = 0;
  if (clGetProgramBuildInfo(program, state.device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size) != CL_SUCCESS) return "";
  std::string text(size, '\0');
  clGetProgramBuildInfo(program, state.device, CL_PROGRAM_BUILD_LOG, size, text.data(), nullptr);
  return text;
}

cl_program build_from_source(const DeviceState& state, const std::string& file, std::string_view source,
                             const std::string& options) {
  cl_int status = CL_SUCCESS;
  const char* text = source.data();
  const std::size_t length = source.size();
  cl_program program = clCreateProgramWithSource(state.context, 1, &text, &length, &status);
  check_cl(status, file + ".cl: clCreateProgramWithSource");
  status = clBuildProgram(program, 1, &state.device, options.c_str(), nullptr, nullptr);
  if (status != CL_SUCCESS) {
    const std::string log = build_log(state, program);
    clReleaseProgram(program);
    throw Error(ErrorCode::kEnvironment, fmt::format("{}.cl does not build on {} with {}: {}\n{}", file,
                                                     state.info.name, options, cl_error_name(status), log));
  }
  return program;
}

// Null when there is no usable binary.
cl_program load_binary(const DeviceState& state, const std::string& path, const std::string& options) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return nullptr;  // reading a folder would throw
  std::ifstream in(path, std::ios::binary);
  if (!in) return nullptr;
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (bytes.size() <= kDigestSize) return nullptr;
  const std::string digest = bytes.substr(bytes.size() - kDigestSize);
  bytes.resize(bytes.size() - kDigestSize);
  if (hash_text(bytes) != digest) {
    log_verbose("program cache: " + path + " is damaged, building anew");
    return nullptr;
  }
  const std::size_t length = bytes.size();
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  cl_int binary_status = CL_SUCCESS, status = CL_SUCCESS;
  cl_program program =
      clCreateProgramWithBinary(state.context, 1, &state.device, &length, &data, &binary_status, &status);
  if (status != CL_SUCCESS || binary_status != CL_SUCCESS) return nullptr;
  if (clBuildProgram(program, 1, &state.device, options.c_str(), nullptr, nullptr) != CL_SUCCESS) {
    clReleaseProgram(program);
    return nullptr;
  }
  return program;
}

// Failing to keep a binary costs the next run a build; it is no reason to fail this one.
void save_binary(cl_program program, const std::string& path) {
  std::size_t length = 0;
  if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof(length), &length, nullptr) != CL_SUCCESS || length == 0)
    return;
  std::string bytes(length, '\0');
  auto* data = reinterpret_cast<unsigned char*>(bytes.data());
  if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof(data), &data, nullptr) != CL_SUCCESS) return;
  try {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    write_text_file(path, bytes + hash_text(bytes));
  } catch (const std::exception& error) {
    log_verbose(std::string("program cache: ") + error.what());
  }
}

}  // namespace

void set_program_cache_folder(const std::string& folder) { g_cache_folder = folder; }

cl_program load_program(DeviceState& state, const std::string& file, const std::string& options) {
  const auto found = kernel_sources().find(file);
  MULTUM_CHECK(found != kernel_sources().end());
  const std::string source = edited_source(found->second, file, state.edits);
  if (g_cache_folder.empty()) return build_from_source(state, file, source, options);
  ContentHash key;
  for (std::string_view part : {std::string_view(source), std::string_view(options), std::string_view(state.info.name),
                                std::string_view(state.info.platform), std::string_view(state.info.driver)}) {
    key.update(part);
    key.update("\n");
  }
  const std::string path = g_cache_folder + "/" + file + "-" + key.finish().substr(0, 32) + ".clbin";
  if (cl_program cached = load_binary(state, path, options)) {
    log_verbose("program cache: " + file + " loaded");
    return cached;
  }
  cl_program program = build_from_source(state, file, source, options);
  save_binary(program, path);
  return program;
}

}  // namespace multum
