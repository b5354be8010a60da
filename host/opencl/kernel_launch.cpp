// SPDX-License-Identifier: Apache-2.0
// Arguments and launches. Every failure names the kernel and OpenCL's own word for it.
#include "host/base/error.h"
#include "host/opencl/cl_error.h"
#include "host/opencl/device.h"
#include "host/opencl/device_state.h"

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
  const std::size_t local = size.local != 0 ? size.local : (device_->info.is_cpu ? 1 : 64);
  const std::size_t global = (size.global + local - 1) / local * local;
  check_cl(clEnqueueNDRangeKernel(device_->queue, static_cast<cl_kernel>(kernel_.get()), 1, nullptr, &global, &local, 0,
                                  nullptr, nullptr),
           "kernel " + name_);
  ++device_->launch_counts[name_];
}

}  // namespace multum
