// SPDX-License-Identifier: Apache-2.0
// This layer between the OpenCL loader and the driver (OPENCL_LAYERS) makes one call fail. It counts the calls that can
// run out of resources, and fails call number failing_layer_fail_at. Calls that release objects never fail.
#define CL_TARGET_OPENCL_VERSION 300
#include <CL/cl_layer.h>

#include <atomic>
#include <cstring>

extern "C" {
__attribute__((visibility("default"))) std::atomic<long> failing_layer_calls{0}, failing_layer_fail_at{-1};
}

namespace {

const cl_icd_dispatch* g_target = nullptr;
cl_icd_dispatch g_dispatch;

bool fails() { return failing_layer_calls++ == failing_layer_fail_at; }

// Wraps a function of the dispatch table. The wrapper returns the error as its result or through its last argument.
template <auto Member>
struct Wrapped;
template <typename... Arguments, cl_int (CL_API_CALL* cl_icd_dispatch::*Member)(Arguments...)>
struct Wrapped<Member> {
  static cl_int CL_API_CALL call(Arguments... arguments) {
    return fails() ? CL_OUT_OF_RESOURCES : (g_target->*Member)(arguments...);
  }
};
template <typename Handle, typename... Arguments, Handle* (CL_API_CALL* cl_icd_dispatch::*Member)(Arguments...)>
struct Wrapped<Member> {
  static Handle* CL_API_CALL call(Arguments... arguments) {
    if (!fails()) return (g_target->*Member)(arguments...);
    cl_int* status = nullptr;
    ((status = last(arguments)), ...);
    if (status != nullptr) *status = CL_OUT_OF_HOST_MEMORY;
    return nullptr;
  }
  static cl_int* last(cl_int* place) { return place; }
  template <typename Other>
  static cl_int* last(Other) {
    return nullptr;
  }
};

}  // namespace

extern "C" {

cl_int clGetLayerInfo(cl_layer_info name, size_t size, void* value, size_t* size_ret) {
  const cl_layer_api_version version = CL_LAYER_API_VERSION_100;
  constexpr char kName[] = "failing layer of multum's tests";
  const void* const from = name == CL_LAYER_API_VERSION ? static_cast<const void*>(&version) : kName;
  const size_t bytes = name == CL_LAYER_API_VERSION ? sizeof(version) : sizeof(kName);
  if (name != CL_LAYER_API_VERSION && name != CL_LAYER_NAME) return CL_INVALID_VALUE;
  if (value != nullptr) {
    if (size < bytes) return CL_INVALID_VALUE;
    std::memcpy(value, from, bytes);
  }
  if (size_ret != nullptr) *size_ret = bytes;
  return CL_SUCCESS;
}

cl_int clInitLayer(cl_uint num_entries, const cl_icd_dispatch* target, cl_uint* num_entries_ret,
                   const cl_icd_dispatch** layer_ret) {
  if (target == nullptr || layer_ret == nullptr || num_entries_ret == nullptr ||
      num_entries < sizeof(g_dispatch) / sizeof(g_dispatch.clGetPlatformIDs))
    return CL_INVALID_VALUE;
  g_target = target;
  g_dispatch = *target;
#define MULTUM_FAILS(name) g_dispatch.name = &Wrapped<&cl_icd_dispatch::name>::call
  MULTUM_FAILS(clCreateBuffer);
  MULTUM_FAILS(clCreateKernel);
  MULTUM_FAILS(clCreateProgramWithSource);
  MULTUM_FAILS(clCreateProgramWithBinary);
  MULTUM_FAILS(clBuildProgram);
  MULTUM_FAILS(clGetProgramInfo);
  MULTUM_FAILS(clSetKernelArg);
  MULTUM_FAILS(clEnqueueNDRangeKernel);
  MULTUM_FAILS(clEnqueueReadBuffer);
  MULTUM_FAILS(clEnqueueWriteBuffer);
  MULTUM_FAILS(clEnqueueCopyBuffer);
  MULTUM_FAILS(clEnqueueFillBuffer);
  MULTUM_FAILS(clEnqueueMapBuffer);
  MULTUM_FAILS(clEnqueueUnmapMemObject);
  MULTUM_FAILS(clFinish);
  MULTUM_FAILS(clFlush);
  MULTUM_FAILS(clWaitForEvents);
#undef MULTUM_FAILS
  *layer_ret = &g_dispatch;
  *num_entries_ret = sizeof(g_dispatch) / sizeof(g_dispatch.clGetPlatformIDs);
  return CL_SUCCESS;
}

}  // extern "C"
