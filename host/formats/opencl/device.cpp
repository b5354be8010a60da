// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/opencl/cl_error.h"
#include "host/formats/opencl/device_state.h"
#include "host/formats/opencl/kernel_caches.h"
#include "host/formats/opencl/pocl_settings.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

struct FoundDevice {
  cl_device_id id;
  DeviceInfo info;
};

std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

std::string device_text(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  check_cl(clGetDeviceInfo(device, what, 0, nullptr, &size), "clGetDeviceInfo");
  std::string text(size, '\0');
  check_cl(clGetDeviceInfo(device, what, size, text.data(), nullptr), "clGetDeviceInfo");
  return trimmed(text);
}

template <typename Value>
Value device_value(cl_device_id device, cl_device_info what) {
  Value value{};
  check_cl(clGetDeviceInfo(device, what, sizeof(value), &value, nullptr), "clGetDeviceInfo");
  return value;
}

std::string platform_text(cl_platform_id platform, cl_platform_info what) {
  std::size_t size = 0;
  check_cl(clGetPlatformInfo(platform, what, 0, nullptr, &size), "clGetPlatformInfo");
  std::string text(size, '\0');
  check_cl(clGetPlatformInfo(platform, what, size, text.data(), nullptr), "clGetPlatformInfo");
  return trimmed(text);
}

bool has_extension(cl_device_id device, const std::string& name) {
  return (" " + device_text(device, CL_DEVICE_EXTENSIONS) + " ").find(" " + name + " ") != std::string::npos;
}

DeviceInfo info_of(cl_device_id id, int index, const std::string& platform) {
  DeviceInfo info{};
  info.index = index;
  info.name = device_text(id, CL_DEVICE_NAME);
  info.platform = platform;
  info.driver = device_text(id, CL_DRIVER_VERSION);
  info.version = device_text(id, CL_DEVICE_VERSION);
  info.is_cpu = (device_value<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
  info.shares_memory = info.is_cpu || device_value<cl_bool>(id, CL_DEVICE_HOST_UNIFIED_MEMORY) != CL_FALSE;
  const auto floats = device_value<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG);
  info.rounds_when_asked = !info.is_cpu && (floats & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.has_atomic_longs = has_extension(id, "cl_khr_int64_base_atomics");
  info.compute_units = static_cast<int>(device_value<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS));
  info.work_group_max = static_cast<int>(device_value<std::size_t>(id, CL_DEVICE_MAX_WORK_GROUP_SIZE));
  info.local_bytes = device_value<cl_ulong>(id, CL_DEVICE_LOCAL_MEM_SIZE);
  info.memory_bytes = device_value<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.buffer_bytes_max = device_value<cl_ulong>(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  if (info.is_cpu) {  // PoCL says what the machine has, whatever a container leaves of it
    info.memory_bytes = std::min(info.memory_bytes, machine_memory_bytes());
    info.buffer_bytes_max = std::min(info.buffer_bytes_max, machine_memory_bytes());
  }
  return info;
}

std::vector<FoundDevice> find_devices() {
  ask_pocl_for_one_version_of_kernels();
  ask_pocl_for_usual_threads();
  prepare_kernel_caches();
  std::vector<FoundDevice> found;
  cl_uint platform_count = 0;
  const cl_int status = clGetPlatformIDs(0, nullptr, &platform_count);
  if (status == CL_PLATFORM_NOT_FOUND_KHR || platform_count == 0) return found;
  check_cl(status, "clGetPlatformIDs");
  std::vector<cl_platform_id> platforms(platform_count);
  check_cl(clGetPlatformIDs(platform_count, platforms.data(), nullptr), "clGetPlatformIDs");
  for (cl_platform_id platform : platforms) {
    cl_uint count = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS || count == 0) continue;
    std::vector<cl_device_id> ids(count);
    check_cl(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr), "clGetDeviceIDs");
    ask_pocl_for_safe_loops(platform_text(platform, CL_PLATFORM_VERSION));
    const std::string name = platform_text(platform, CL_PLATFORM_NAME);
    for (cl_device_id id : ids) found.push_back({id, info_of(id, static_cast<int>(found.size()), name)});
  }
  return found;
}

bool has_in_name(const DeviceInfo& info, const std::string& selector) {
  return info.name.find(selector) != std::string::npos || info.platform.find(selector) != std::string::npos;
}

void CL_CALLBACK on_context_error(const char* message, const void*, std::size_t, void*) {
  log_warning("OpenCL", message);
}

}  // namespace

std::optional<std::size_t> choose_device(const std::vector<DeviceInfo>& devices, const std::string& selector) {
  if (selector.empty()) {
    for (bool want_cpu : {false, true})
      for (std::size_t i = 0; i < devices.size(); ++i)
        if (devices[i].is_cpu == want_cpu) return i;
    return std::nullopt;
  }
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (std::to_string(devices[i].index) == selector) return i;
  for (std::size_t i = 0; i < devices.size(); ++i)  // a number of a name: "4090"
    if (has_in_name(devices[i], selector)) return i;
  return std::nullopt;
}

namespace {

std::vector<DeviceInfo> infos_of(const std::vector<FoundDevice>& devices) {
  std::vector<DeviceInfo> infos;
  for (const FoundDevice& device : devices) infos.push_back(device.info);
  return infos;
}

}  // namespace

std::vector<DeviceInfo> list_devices() { return infos_of(find_devices()); }

DeviceState::~DeviceState() {
  release_staging(*this);
  for (auto& entry : programs) clReleaseProgram(entry.second);
  if (queue != nullptr) clReleaseCommandQueue(queue);
  if (context != nullptr) clReleaseContext(context);
}

namespace {

std::shared_ptr<DeviceState> open_state(const std::string& selector) {
  const std::vector<FoundDevice> devices = find_devices();
  if (devices.empty())
    throw Error(ErrorCode::kEnvironment,
                "no OpenCL device found; expected a driver such as PoCL (Debian package pocl-opencl-icd)" +
                    (pocl_cache_failure().empty() ? "" : "; " + pocl_cache_failure()));
  const std::optional<std::size_t> number = choose_device(infos_of(devices), selector);
  if (!number) {
    std::string known;
    for (const FoundDevice& device : devices) known += fmt::format("\n  {}: {}", device.info.index, device.info.name);
    throw Error(ErrorCode::kEnvironment,
                "no OpenCL device matches '" + selector + "'; expected a number or part of a name of" + known);
  }
  auto opened = std::make_shared<DeviceState>();
  DeviceState& state = *opened;
  state.info = devices[*number].info;
  state.device = devices[*number].id;
  cl_int status = CL_SUCCESS;
  state.context = clCreateContext(nullptr, 1, &state.device, on_context_error, nullptr, &status);
  check_cl(status, state.info.name + ": clCreateContext");
  state.queue = clCreateCommandQueue(state.context, state.device, 0, &status);
  check_cl(status, state.info.name + ": clCreateCommandQueue");
  state.shape = LaunchShape::of(state.info);
  return opened;
}

}  // namespace

Device Device::open(const std::string& selector) { return open(DeviceChoice{selector}); }

Device Device::open(const DeviceChoice& choice) {
  Device device = when_needed(choice);
  device.opened();
  return device;
}

Device Device::when_needed(const DeviceChoice& choice) {
  Device device;
  device.choice_ = choice;
  return device;
}

const std::shared_ptr<DeviceState>& Device::opened() const {
  if (state_ == nullptr) {
    state_ = open_state(choice_.selector);
    if (choice_.as_accelerator) state_->shape = LaunchShape::of_accelerator(state_->info);
  }
  return state_;
}

DeviceState& Device::state() const { return *opened(); }

const DeviceInfo& Device::info() const { return state().info; }
const LaunchShape& Device::shape() const { return state().shape; }
void Device::set_shape(const LaunchShape& shape) { state().shape = shape; }
const std::map<std::string, std::uint64_t>& Device::launch_counts() const { return state().launch_counts; }
std::uint64_t Device::launch_total() const {
  std::uint64_t sum = 0;
  for (const auto& entry : state().launch_counts) sum += entry.second;
  return sum;
}
int Device::unprepared_count() const { return state().unprepared_count; }
int Device::program_count() const { return static_cast<int>(state().programs.size()); }

std::map<std::string, int> Device::build_counts() const {
  std::map<std::string, int> counts;
  for (const auto& [key, program] : state().programs) ++counts[key.substr(0, key.find(' '))];
  return counts;
}

namespace {

std::shared_ptr<void> create_memory(const DeviceState& state, cl_mem_flags flags, std::size_t byte_count, void* host,
                                    const std::string& what) {
  if (byte_count > state.info.buffer_bytes_max)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: needs a buffer of {} MiB, the device {} allows at most {} MiB", what, byte_count >> 20,
                            state.info.name, state.info.buffer_bytes_max >> 20));
  cl_int status = CL_SUCCESS;
  cl_mem memory = clCreateBuffer(state.context, flags, std::max<std::size_t>(byte_count, 1), host, &status);
  check_cl(status, fmt::format("{}: a buffer of {} bytes", what, byte_count));
  const std::shared_ptr<BufferBytes> counted = state.buffer_bytes;
  const std::size_t bytes = (flags & CL_MEM_USE_HOST_PTR) != 0 ? 0 : byte_count;
  counted->now += bytes;
  counted->peak = std::max(counted->peak, counted->now);
  return {memory, [counted, bytes](void* m) {
            counted->now -= bytes;
            clReleaseMemObject(static_cast<cl_mem>(m));
          }};
}

}  // namespace

DeviceBuffer Device::make_buffer(std::size_t byte_count, const std::string& what) {
  DeviceBuffer buffer;
  buffer.memory_ = create_memory(state(), CL_MEM_READ_WRITE, byte_count, nullptr, what);
  buffer.byte_count_ = byte_count;
  return buffer;
}

DeviceBuffer Device::wrap_buffer(const void* data, std::size_t byte_count, const std::string& what) {
  DeviceBuffer buffer;
  const cl_mem_flags how = state().shape.staging_bytes == 0 ? CL_MEM_USE_HOST_PTR : CL_MEM_COPY_HOST_PTR;
  buffer.memory_ = create_memory(state(), CL_MEM_READ_ONLY | how, byte_count, const_cast<void*>(data), what);
  state().count_upload(byte_count);
  buffer.byte_count_ = byte_count;
  return buffer;
}

void Device::finish() { check_cl(clFinish(state().queue), "clFinish"); }
void Device::flush() { check_cl(clFlush(state().queue), "clFlush"); }

std::uint64_t Device::buffer_bytes_peak() const { return state().buffer_bytes->peak; }
void Device::restart_buffer_peak() {
  if (is_open()) state_->buffer_bytes->peak = state_->buffer_bytes->now;
}

void Device::time_launches(bool on) {
  if (!on && state_ == nullptr) return;
  if (on == state().times_launches) return;
  finish();
  release_staging(state());  // mapped by the queue that goes
  cl_int status = CL_SUCCESS;
  QueueHandle queue(clCreateCommandQueue(state().context, state().device, on ? CL_QUEUE_PROFILING_ENABLE : 0, &status));
  check_cl(status, state().info.name + ": clCreateCommandQueue");
  collect_times(state());
  clReleaseCommandQueue(std::exchange(state().queue, queue.release()));
  state().times_launches = on;
}

std::map<std::string, double> Device::launch_seconds() {
  finish();
  collect_times(state());
  return state().launch_seconds;
}

double Device::timed_seconds() {
  if (!is_open() || !state_->times_launches) return 0.0;
  double sum = 0.0;
  for (const auto& [kernel, seconds] : launch_seconds()) sum += seconds;
  return sum;
}

void Device::edit_kernels(std::vector<SourceEdit> edits) { state().edits = std::move(edits); }

bool Device::kernels_are_edited() const { return !state().edits.empty(); }

void Device::prepare(const std::vector<ProgramChoice>& programs) {
  for (const ProgramChoice& program : programs)
    prepare_program(state(), program.file, build_options(program.variant, state().info.rounds_when_asked));
}

Kernel Device::kernel(const std::string& file, const std::string& kernel_name, const KernelVariant& variant) {
  const std::string options = build_options(variant, state().info.rounds_when_asked);
  const std::string key = program_key(state(), file, options);
  auto found = state().programs.find(key);
  if (found == state().programs.end())
    found = state().programs.emplace(key, load_program(state(), file, options)).first;
  cl_int status = CL_SUCCESS;
  cl_kernel made = clCreateKernel(found->second, kernel_name.c_str(), &status);
  check_cl(status, "kernel " + kernel_name + " of " + file + ".cl");
  Kernel kernel;
  kernel.device_ = opened();
  kernel.kernel_ = {made, [](void* k) { clReleaseKernel(static_cast<cl_kernel>(k)); }};
  kernel.name_ = kernel_name;
  return kernel;
}

}  // namespace multum
