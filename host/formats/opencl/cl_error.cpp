// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/cl_error.h"

#include "host/formats/opencl/cl_headers.h"
#include "host/foundation/base/error.h"

namespace multum {

std::string cl_error_name(int status) {
  const char* name = "unknown OpenCL error";
#define NAME(code) \
  case code: name = #code; break
  switch (status) {
    NAME(CL_SUCCESS);
    NAME(CL_DEVICE_NOT_FOUND);
    NAME(CL_DEVICE_NOT_AVAILABLE);
    NAME(CL_COMPILER_NOT_AVAILABLE);
    NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE);
    NAME(CL_OUT_OF_RESOURCES);
    NAME(CL_OUT_OF_HOST_MEMORY);
    NAME(CL_BUILD_PROGRAM_FAILURE);
    NAME(CL_MAP_FAILURE);
    NAME(CL_INVALID_VALUE);
    NAME(CL_INVALID_DEVICE);
    NAME(CL_INVALID_CONTEXT);
    NAME(CL_INVALID_COMMAND_QUEUE);
    NAME(CL_INVALID_MEM_OBJECT);
    NAME(CL_INVALID_BINARY);
    NAME(CL_INVALID_BUILD_OPTIONS);
    NAME(CL_INVALID_PROGRAM);
    NAME(CL_INVALID_PROGRAM_EXECUTABLE);
    NAME(CL_INVALID_KERNEL_NAME);
    NAME(CL_INVALID_KERNEL);
    NAME(CL_INVALID_ARG_INDEX);
    NAME(CL_INVALID_ARG_VALUE);
    NAME(CL_INVALID_ARG_SIZE);
    NAME(CL_INVALID_KERNEL_ARGS);
    NAME(CL_INVALID_WORK_GROUP_SIZE);
    NAME(CL_INVALID_WORK_ITEM_SIZE);
    NAME(CL_INVALID_GLOBAL_WORK_SIZE);
    NAME(CL_INVALID_BUFFER_SIZE);
    NAME(CL_PLATFORM_NOT_FOUND_KHR);
    default: break;
  }
#undef NAME
  return std::string(name) + " (" + std::to_string(status) + ")";
}

void check_cl(int status, const std::string& what) {
  if (status != CL_SUCCESS) throw Error(ErrorCode::kEnvironment, what + ": " + cl_error_name(status));
}

}  // namespace multum
