// SPDX-License-Identifier: Apache-2.0
// An OpenCL device with its context, queue, programs and launch counts. No OpenCL type leaves this folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/base/source_edit.h"
#include "host/opencl/build_options.h"

namespace multum {

struct DeviceInfo {
  int index;  // as `multum devices` numbers them
  std::string name;
  std::string platform;
  std::string driver;
  bool is_cpu;
  std::uint64_t memory_bytes;
  std::uint64_t buffer_bytes_max;
};

/// Every device of every platform; empty when there is none.
std::vector<DeviceInfo> list_devices();

class DeviceState;

/// Memory on the device. Movable; released when destroyed.
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  std::size_t byte_count() const { return byte_count_; }

 private:
  friend class Device;
  friend class Kernel;
  std::shared_ptr<void> memory_;
  std::size_t byte_count_ = 0;
};

/// A kernel of one program variant. Arguments are buffers or plain structs and numbers, in the kernel's order.
class Kernel {
 public:
  struct WorkSize {
    std::size_t global;     // work-items wanted; rounded up to a multiple of `local`, so kernels check their bounds
    std::size_t local = 0;  // 0: the device's usual size
  };

  bool is_made() const { return kernel_ != nullptr; }

  template <typename... Arguments>
  void launch(const WorkSize& size, const Arguments&... arguments) {
    int index = 0;
    (set_argument(index++, arguments), ...);
    enqueue(size);
  }

 private:
  friend class Device;
  void set_argument(int index, const DeviceBuffer& buffer);
  template <typename Plain>
  void set_argument(int index, const Plain& value) {
    static_assert(std::is_trivially_copyable_v<Plain>);
    set_bytes(index, &value, sizeof(value));
  }
  void set_bytes(int index, const void* bytes, std::size_t byte_count);
  void enqueue(const WorkSize& size);

  std::shared_ptr<DeviceState> device_;
  std::shared_ptr<void> kernel_;
  std::string name_;
};

class Device {
 public:
  /// `selector`: empty = the first GPU, else the first CPU; a number of `multum devices`; or a part of a device's or
  /// platform's name. Throws Error(kEnvironment) when there is no such device, listing those there are.
  static Device open(const std::string& selector);

  const DeviceInfo& info() const;
  /// Width of the kernels' fast variant here: 16 on CPUs, 1 on GPUs.
  int vector_width() const { return info().is_cpu ? 16 : 1; }

  /// Throws Error(kEnvironment) when it is larger than the device's buffers may be.
  DeviceBuffer make_buffer(std::size_t byte_count, const std::string& what);
  /// Uses the caller's memory without a copy on CPUs, copies on others; `data` must outlive the buffer and not change.
  DeviceBuffer wrap_buffer(const void* data, std::size_t byte_count, const std::string& what);
  /// From and to the buffer's beginning. Wait for the launches before.
  void write(DeviceBuffer& buffer, const void* data, std::size_t byte_count);
  void read(const DeviceBuffer& buffer, void* data, std::size_t byte_count);
  /// Calls `body` with the buffer's bytes, on CPUs without a copy; what it changes is in the buffer afterwards. Waits
  /// for the launches before.
  void visit(const DeviceBuffer& buffer, const std::function<void(void* bytes)>& body);
  void fill_zero(DeviceBuffer& buffer);

  /// A kernel of kernels/FILE.cl, built with the variant's options or taken from the program cache.
  Kernel kernel(const std::string& file, const std::string& kernel_name, const KernelVariant& variant);

  /// From now on programs are built from kernels edited so; an empty list ends that. Kernels made before stay as they
  /// are. For showing what a guard is for (host/selftest), never for a bake.
  void edit_kernels(std::vector<SourceEdit> edits);

  /// Waits for all launches.
  void finish();
  /// Hands queued launches to the device.
  void flush();

  /// Launches so far, by kernel name; programs built or loaded from the cache so far.
  const std::map<std::string, std::uint64_t>& launch_counts() const;
  std::uint64_t launch_total() const;
  int program_count() const;
  /// Of these, by kernels/FILE.cl.
  std::map<std::string, int> build_counts() const;

 private:
  std::shared_ptr<DeviceState> state_;
};

}  // namespace multum
