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
  cl::Device device;
  DeviceInfo info;
};

template <auto What, typename Of>
auto value_of(const Of& of, const char* call) {
  cl_int status = CL_SUCCESS;
  auto value = of.template getInfo<What>(&status);
  check_cl(status, call);
  return value;
}

template <auto What>
auto device_value(const cl::Device& device) {
  return value_of<What>(device, "clGetDeviceInfo");
}

std::string trimmed(std::string text) {
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

template <auto What>
std::string device_text(const cl::Device& device) {
  return trimmed(device_value<What>(device));
}

bool has_extension(const cl::Device& device, const std::string& name) {
  return (" " + device_text<CL_DEVICE_EXTENSIONS>(device) + " ").find(" " + name + " ") != std::string::npos;
}

DeviceInfo info_of(const cl::Device& device, int index, const std::string& platform) {
  DeviceInfo info{};
  info.index = index;
  info.name = device_text<CL_DEVICE_NAME>(device);
  info.platform = platform;
  info.driver = device_text<CL_DRIVER_VERSION>(device);
  info.version = device_text<CL_DEVICE_VERSION>(device);
  info.is_cpu = (device_value<CL_DEVICE_TYPE>(device) & CL_DEVICE_TYPE_CPU) != 0;
  info.shares_memory = info.is_cpu || device_value<CL_DEVICE_HOST_UNIFIED_MEMORY>(device) != CL_FALSE;
  const auto floats = device_value<CL_DEVICE_SINGLE_FP_CONFIG>(device);
  info.rounds_when_asked = !info.is_cpu && (floats & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.has_atomic_longs = has_extension(device, "cl_khr_int64_base_atomics");
  info.compute_units = static_cast<int>(device_value<CL_DEVICE_MAX_COMPUTE_UNITS>(device));
  info.work_group_max = static_cast<int>(device_value<CL_DEVICE_MAX_WORK_GROUP_SIZE>(device));
  info.local_bytes = device_value<CL_DEVICE_LOCAL_MEM_SIZE>(device);
  info.memory_bytes = device_value<CL_DEVICE_GLOBAL_MEM_SIZE>(device);
  info.buffer_bytes_max = device_value<CL_DEVICE_MAX_MEM_ALLOC_SIZE>(device);
  if (info.is_cpu) {  // PoCL reports the machine's memory and ignores a container's limit
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
  std::vector<cl::Platform> platforms;
  if (cl::Platform::get(&platforms) != CL_SUCCESS) return found;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> devices;
    if (platform.getDevices(CL_DEVICE_TYPE_ALL, &devices) != CL_SUCCESS) continue;
    ask_pocl_for_safe_loops(value_of<CL_PLATFORM_VERSION>(platform, "clGetPlatformInfo"));
    const std::string name = trimmed(value_of<CL_PLATFORM_NAME>(platform, "clGetPlatformInfo"));
    for (const cl::Device& device : devices)
      found.push_back({device, info_of(device, static_cast<int>(found.size()), name)});
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
  for (std::size_t i = 0; i < devices.size(); ++i)  // the selector may be part of a name: "4090"
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

DeviceState::~DeviceState() { release_staging(*this); }

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
    throw Error(ErrorCode::kEnvironment, "no OpenCL device matches '" + selector +
                                             "'; expected a number or a part of a name from this list:" + known);
  }
  auto opened = std::make_shared<DeviceState>();
  DeviceState& state = *opened;
  state.info = devices[*number].info;
  state.device = devices[*number].device;
  cl_int status = CL_SUCCESS;
  state.context = cl::Context(state.device, nullptr, on_context_error, nullptr, &status);
  check_cl(status, state.info.name + ": clCreateContext");
  state.queue = cl::CommandQueue(state.context, state.device, 0, &status);
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

std::shared_ptr<cl::Buffer> create_memory(const DeviceState& state, cl_mem_flags flags, std::size_t byte_count,
                                          void* host, const std::string& what) {
  if (byte_count > state.info.buffer_bytes_max)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: needs a buffer of {} MiB, but the device {} allows at most {} MiB per buffer", what,
                            byte_count >> 20, state.info.name, state.info.buffer_bytes_max >> 20));
  cl_int status = CL_SUCCESS;
  cl::Buffer memory(state.context, flags, std::max<std::size_t>(byte_count, 1), host, &status);
  check_cl(status, fmt::format("{}: a buffer of {} bytes", what, byte_count));
  const std::shared_ptr<BufferBytes> counted = state.buffer_bytes;
  const std::size_t bytes = (flags & CL_MEM_USE_HOST_PTR) != 0 ? 0 : byte_count;
  counted->now += bytes;
  counted->peak = std::max(counted->peak, counted->now);
  return {new cl::Buffer(std::move(memory)), [counted, bytes](cl::Buffer* buffer) {
            counted->now -= bytes;
            delete buffer;
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

void Device::finish() { check_cl(state().queue.finish(), "clFinish"); }
void Device::flush() { check_cl(state().queue.flush(), "clFlush"); }

std::uint64_t Device::buffer_bytes_peak() const { return state().buffer_bytes->peak; }
void Device::restart_buffer_peak() {
  if (is_open()) state_->buffer_bytes->peak = state_->buffer_bytes->now;
}

void Device::time_launches(bool on) {
  if (!on && state_ == nullptr) return;
  if (on == state().times_launches) return;
  finish();
  release_staging(state());  // staging buffers are mapped by the queue that is about to close
  cl_int status = CL_SUCCESS;
  cl::CommandQueue queue(state().context, state().device, on ? CL_QUEUE_PROFILING_ENABLE : 0, &status);
  check_cl(status, state().info.name + ": clCreateCommandQueue");
  collect_times(state());
  state().queue = std::move(queue);
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
  const cl::Kernel made(found->second, kernel_name.c_str(), &status);
  check_cl(status, "kernel " + kernel_name + " of " + file + ".cl");
  Kernel kernel;
  kernel.device_ = opened();
  kernel.kernel_ = std::make_shared<cl::Kernel>(made);
  kernel.name_ = kernel_name;
  return kernel;
}

}  // namespace multum
