// SPDX-License-Identifier: Apache-2.0
// What a Device and its kernels share. Private to host/opencl.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/opencl/cl_headers.h"
#include "host/opencl/device.h"

namespace multum {

class DeviceState {
 public:
  DeviceState() = default;
  ~DeviceState();
  DeviceState(const DeviceState&) = delete;
  DeviceState& operator=(const DeviceState&) = delete;

  DeviceInfo info;
  cl_device_id device = nullptr;
  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
  std::map<std::string, cl_program> programs;  // by file, options and edits of the file
  std::vector<SourceEdit> edits;
  std::map<std::string, std::uint64_t> launch_counts;
};

/// Builds kernels/FILE.cl with `options`, or loads the binary that an earlier run left in the cache folder.
cl_program load_program(DeviceState& state, const std::string& file, const std::string& options);

}  // namespace multum
