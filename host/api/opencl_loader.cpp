// SPDX-License-Identifier: Apache-2.0
// Loads libOpenCL.so.1 at the first call. On machines without OpenCL, libmultum can therefore be loaded, and it can
// read and shade maps. Defines the functions of OpenCL 1.2 that host/formats/opencl calls. They are hidden symbols of
// libmultum, and each one calls the function of the same name in the real library.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>

namespace {

// Returns null if the library or the function is missing.
void* find_function(const char* name) {
  static void* const library = ::dlopen("libOpenCL.so.1", RTLD_NOW | RTLD_LOCAL);
  return library == nullptr ? nullptr : ::dlsym(library, name);
}

constexpr cl_int kPlatformNotFound = -1001;  // CL_PLATFORM_NOT_FOUND_KHR

// Without the library, a program calls only clGetPlatformIDs(), because every other call needs a platform.
template <typename Result>
Result missing() {
  return {};
}
template <>
cl_int missing() {
  return kPlatformNotFound;
}

}  // namespace

#define MULTUM_CALL_OPENCL(name, ...)                                                      \
  static auto* const function = reinterpret_cast<decltype(&::name)>(find_function(#name)); \
  return function == nullptr ? missing<decltype(::name(__VA_ARGS__))>() : function(__VA_ARGS__)

extern "C" {

cl_int clBuildProgram(cl_program program, cl_uint num_devices, const cl_device_id* device_list, const char* options,
                      void(CL_CALLBACK* pfn_notify)(cl_program program, void* user_data), void* user_data) {
  MULTUM_CALL_OPENCL(clBuildProgram, program, num_devices, device_list, options, pfn_notify, user_data);
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host_ptr, cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateBuffer, context, flags, size, host_ptr, errcode_ret);
}

cl_command_queue clCreateCommandQueue(cl_context context, cl_device_id device, cl_command_queue_properties properties,
                                      cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateCommandQueue, context, device, properties, errcode_ret);
}

cl_context clCreateContext(const cl_context_properties* properties, cl_uint num_devices, const cl_device_id* devices,
                           void(CL_CALLBACK* pfn_notify)(const char* errinfo, const void* private_info, size_t cb,
                                                         void* user_data),
                           void* user_data, cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateContext, properties, num_devices, devices, pfn_notify, user_data, errcode_ret);
}

cl_kernel clCreateKernel(cl_program program, const char* kernel_name, cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateKernel, program, kernel_name, errcode_ret);
}

cl_program clCreateProgramWithBinary(cl_context context, cl_uint num_devices, const cl_device_id* device_list,
                                     const size_t* lengths, const unsigned char** binaries, cl_int* binary_status,
                                     cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateProgramWithBinary, context, num_devices, device_list, lengths, binaries, binary_status,
                     errcode_ret);
}

cl_program clCreateProgramWithSource(cl_context context, cl_uint count, const char** strings, const size_t* lengths,
                                     cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clCreateProgramWithSource, context, count, strings, lengths, errcode_ret);
}

cl_int clEnqueueCopyBuffer(cl_command_queue command_queue, cl_mem src_buffer, cl_mem dst_buffer, size_t src_offset,
                           size_t dst_offset, size_t size, cl_uint num_events_in_wait_list,
                           const cl_event* event_wait_list, cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueCopyBuffer, command_queue, src_buffer, dst_buffer, src_offset, dst_offset, size,
                     num_events_in_wait_list, event_wait_list, event);
}

cl_int clEnqueueFillBuffer(cl_command_queue command_queue, cl_mem buffer, const void* pattern, size_t pattern_size,
                           size_t offset, size_t size, cl_uint num_events_in_wait_list, const cl_event* event_wait_list,
                           cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueFillBuffer, command_queue, buffer, pattern, pattern_size, offset, size,
                     num_events_in_wait_list, event_wait_list, event);
}

void* clEnqueueMapBuffer(cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_map, cl_map_flags map_flags,
                         size_t offset, size_t size, cl_uint num_events_in_wait_list, const cl_event* event_wait_list,
                         cl_event* event, cl_int* errcode_ret) {
  MULTUM_CALL_OPENCL(clEnqueueMapBuffer, command_queue, buffer, blocking_map, map_flags, offset, size,
                     num_events_in_wait_list, event_wait_list, event, errcode_ret);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue command_queue, cl_kernel kernel, cl_uint work_dim,
                              const size_t* global_work_offset, const size_t* global_work_size,
                              const size_t* local_work_size, cl_uint num_events_in_wait_list,
                              const cl_event* event_wait_list, cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueNDRangeKernel, command_queue, kernel, work_dim, global_work_offset, global_work_size,
                     local_work_size, num_events_in_wait_list, event_wait_list, event);
}

cl_int clEnqueueReadBuffer(cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_read, size_t offset,
                           size_t size, void* ptr, cl_uint num_events_in_wait_list, const cl_event* event_wait_list,
                           cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueReadBuffer, command_queue, buffer, blocking_read, offset, size, ptr,
                     num_events_in_wait_list, event_wait_list, event);
}

cl_int clEnqueueUnmapMemObject(cl_command_queue command_queue, cl_mem memobj, void* mapped_ptr,
                               cl_uint num_events_in_wait_list, const cl_event* event_wait_list, cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueUnmapMemObject, command_queue, memobj, mapped_ptr, num_events_in_wait_list,
                     event_wait_list, event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue command_queue, cl_mem buffer, cl_bool blocking_write, size_t offset,
                            size_t size, const void* ptr, cl_uint num_events_in_wait_list,
                            const cl_event* event_wait_list, cl_event* event) {
  MULTUM_CALL_OPENCL(clEnqueueWriteBuffer, command_queue, buffer, blocking_write, offset, size, ptr,
                     num_events_in_wait_list, event_wait_list, event);
}

cl_int clFinish(cl_command_queue command_queue) { MULTUM_CALL_OPENCL(clFinish, command_queue); }

cl_int clFlush(cl_command_queue command_queue) { MULTUM_CALL_OPENCL(clFlush, command_queue); }

cl_int clGetDeviceIDs(cl_platform_id platform, cl_device_type device_type, cl_uint num_entries, cl_device_id* devices,
                      cl_uint* num_devices) {
  MULTUM_CALL_OPENCL(clGetDeviceIDs, platform, device_type, num_entries, devices, num_devices);
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info param_name, size_t param_value_size, void* param_value,
                       size_t* param_value_size_ret) {
  MULTUM_CALL_OPENCL(clGetDeviceInfo, device, param_name, param_value_size, param_value, param_value_size_ret);
}

cl_int clGetEventProfilingInfo(cl_event event, cl_profiling_info param_name, size_t param_value_size, void* param_value,
                               size_t* param_value_size_ret) {
  MULTUM_CALL_OPENCL(clGetEventProfilingInfo, event, param_name, param_value_size, param_value, param_value_size_ret);
}

cl_int clGetPlatformIDs(cl_uint num_entries, cl_platform_id* platforms, cl_uint* num_platforms) {
  MULTUM_CALL_OPENCL(clGetPlatformIDs, num_entries, platforms, num_platforms);
}

cl_int clGetPlatformInfo(cl_platform_id platform, cl_platform_info param_name, size_t param_value_size,
                         void* param_value, size_t* param_value_size_ret) {
  MULTUM_CALL_OPENCL(clGetPlatformInfo, platform, param_name, param_value_size, param_value, param_value_size_ret);
}

cl_int clGetProgramBuildInfo(cl_program program, cl_device_id device, cl_program_build_info param_name,
                             size_t param_value_size, void* param_value, size_t* param_value_size_ret) {
  MULTUM_CALL_OPENCL(clGetProgramBuildInfo, program, device, param_name, param_value_size, param_value,
                     param_value_size_ret);
}

cl_int clGetProgramInfo(cl_program program, cl_program_info param_name, size_t param_value_size, void* param_value,
                        size_t* param_value_size_ret) {
  MULTUM_CALL_OPENCL(clGetProgramInfo, program, param_name, param_value_size, param_value, param_value_size_ret);
}

cl_int clReleaseCommandQueue(cl_command_queue command_queue) {
  MULTUM_CALL_OPENCL(clReleaseCommandQueue, command_queue);
}

cl_int clReleaseContext(cl_context context) { MULTUM_CALL_OPENCL(clReleaseContext, context); }

cl_int clReleaseDevice(cl_device_id device) { MULTUM_CALL_OPENCL(clReleaseDevice, device); }

cl_int clReleaseEvent(cl_event event) { MULTUM_CALL_OPENCL(clReleaseEvent, event); }

cl_int clReleaseKernel(cl_kernel kernel) { MULTUM_CALL_OPENCL(clReleaseKernel, kernel); }

cl_int clReleaseMemObject(cl_mem memobj) { MULTUM_CALL_OPENCL(clReleaseMemObject, memobj); }

cl_int clReleaseProgram(cl_program program) { MULTUM_CALL_OPENCL(clReleaseProgram, program); }

cl_int clRetainCommandQueue(cl_command_queue command_queue) { MULTUM_CALL_OPENCL(clRetainCommandQueue, command_queue); }

cl_int clRetainDevice(cl_device_id device) { MULTUM_CALL_OPENCL(clRetainDevice, device); }

cl_int clRetainKernel(cl_kernel kernel) { MULTUM_CALL_OPENCL(clRetainKernel, kernel); }

cl_int clRetainMemObject(cl_mem memobj) { MULTUM_CALL_OPENCL(clRetainMemObject, memobj); }

cl_int clRetainProgram(cl_program program) { MULTUM_CALL_OPENCL(clRetainProgram, program); }

cl_int clSetKernelArg(cl_kernel kernel, cl_uint arg_index, size_t arg_size, const void* arg_value) {
  MULTUM_CALL_OPENCL(clSetKernelArg, kernel, arg_index, arg_size, arg_value);
}

cl_int clWaitForEvents(cl_uint num_events, const cl_event* event_list) {
  MULTUM_CALL_OPENCL(clWaitForEvents, num_events, event_list);
}

}  // extern "C"
