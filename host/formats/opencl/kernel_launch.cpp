// SPDX-License-Identifier: Apache-2.0
// Sets arguments and launches kernels. Every failure message names the kernel and OpenCL's error code.
#include <algorithm>
#include <utility>

#include "host/formats/opencl/cl_error.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/device_state.h"
#include "host/foundation/base/error.h"

namespace multum {

void Kernel::set_argument(int index, const DeviceBuffer& buffer) {
  const cl_mem memory = (*buffer.memory_)();
  set_bytes(index, &memory, sizeof(memory));
}

void Kernel::set_bytes(int index, const void* bytes, std::size_t byte_count) {
  check_cl(kernel_->setArg(static_cast<cl_uint>(index), byte_count, bytes),
           "kernel " + name_ + ", argument " + std::to_string(index));
}

void Kernel::enqueue(const WorkSize& size) {
  if (size.global == 0) return;
  // Local sizes are set explicitly, because PoCL compiles a kernel once per size, and leaves a thread idle when it
  // chooses the size itself. A team needs a local size that equals its number of work-items. Therefore LaunchShape
  // allows teams only on devices whose work-groups can be that large.
  const std::size_t wanted = size.local != 0 ? size.local : device_->shape.local_size;
  const std::size_t local = std::min(wanted, static_cast<std::size_t>(std::max(1, device_->info.work_group_max)));
  const std::size_t global = (size.global + local - 1) / local * local;
  cl::Event event;
  check_cl(device_->queue.enqueueNDRangeKernel(*kernel_, cl::NullRange, cl::NDRange(global), cl::NDRange(local),
                                               nullptr, device_->times_launches ? &event : nullptr),
           "kernel " + name_);
  ++device_->launch_counts[name_];
  if (!device_->times_launches) return;
  constexpr std::size_t kTimedMax = 4096;  // limited because events that have not been read need memory in the driver
  device_->timed.emplace_back(name_, std::move(event));
  if (device_->timed.size() >= kTimedMax) collect_times(*device_);
}

void collect_times(DeviceState& state) {
  const auto timed = std::exchange(state.timed, {});
  for (const auto& [name, event] : timed) {
    check_cl(event.wait(), "clWaitForEvents");
    cl_ulong begin = 0, end = 0;
    check_cl(event.getProfilingInfo(CL_PROFILING_COMMAND_START, &begin),
             "kernel " + name + ": clGetEventProfilingInfo");
    check_cl(event.getProfilingInfo(CL_PROFILING_COMMAND_END, &end), "kernel " + name + ": clGetEventProfilingInfo");
    state.launch_seconds[name] += static_cast<double>(end - begin) * 1e-9;
  }
}

}  // namespace multum
