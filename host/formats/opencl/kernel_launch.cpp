// SPDX-License-Identifier: Apache-2.0
// Arguments and launches. Every failure names the kernel and OpenCL's own word for it.
#include <algorithm>
#include <utility>

#include "host/formats/opencl/cl_error.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/device_state.h"
#include "host/foundation/base/error.h"

namespace multum {

void Kernel::set_argument(int index, const DeviceBuffer& buffer) {
  auto memory = static_cast<cl_mem>(buffer.memory_.get());
  set_bytes(index, &memory, sizeof(memory));
}

void Kernel::set_bytes(int index, const void* bytes, std::size_t byte_count) {
  check_cl(clSetKernelArg(static_cast<cl_kernel>(kernel_.get()), static_cast<cl_uint>(index), byte_count, bytes),
           "kernel " + name_ + ", argument " + std::to_string(index));
}

void Kernel::enqueue(const WorkSize& size) {
  if (size.global == 0) return;
  // An explicit local size: PoCL compiles a kernel once for each, and leaves a thread idle when it must choose itself.
  // Teams, whose size is part of what they do, are not for a device without room for them (LaunchShape).
  const std::size_t wanted = size.local != 0 ? size.local : device_->shape.local_size;
  const std::size_t local = std::min(wanted, static_cast<std::size_t>(std::max(1, device_->info.work_group_max)));
  const std::size_t global = (size.global + local - 1) / local * local;
  cl_event made = nullptr;
  check_cl(clEnqueueNDRangeKernel(device_->queue, static_cast<cl_kernel>(kernel_.get()), 1, nullptr, &global, &local, 0,
                                  nullptr, device_->times_launches ? &made : nullptr),
           "kernel " + name_);
  EventHandle event(made);
  ++device_->launch_counts[name_];
  if (event == nullptr) return;
  constexpr std::size_t kTimedMax = 4096;  // events are memory of the driver
  device_->timed.emplace_back(name_, std::move(event));
  if (device_->timed.size() >= kTimedMax) collect_times(*device_);
}

void collect_times(DeviceState& state) {
  const auto timed = std::exchange(state.timed, {});
  for (const auto& [name, handle] : timed) {
    const cl_event event = handle.get();
    check_cl(clWaitForEvents(1, &event), "clWaitForEvents");
    cl_ulong begin = 0, end = 0;
    check_cl(clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof(begin), &begin, nullptr),
             "kernel " + name + ": clGetEventProfilingInfo");
    check_cl(clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof(end), &end, nullptr),
             "kernel " + name + ": clGetEventProfilingInfo");
    state.launch_seconds[name] += static_cast<double>(end - begin) * 1e-9;
  }
}

}  // namespace multum
