// SPDX-License-Identifier: Apache-2.0
// An OpenCL device with its context, queue, programs and launch counts. No OpenCL type leaves this folder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/opencl/build_options.h"
#include "host/foundation/base/source_edit.h"

namespace cl {
class Buffer;
class Kernel;
}  // namespace cl

namespace multum {

struct DeviceInfo {
  int index;  // as `multum devices` numbers them
  std::string name;
  std::string platform;
  std::string driver;
  std::string version;  // of OpenCL, with what the driver adds
  bool is_cpu;
  bool shares_memory;      // with the host: nothing is gained by few copies
  bool rounds_when_asked;  // divides and takes roots as IEEE says, but only when a program is built so
  bool has_atomic_longs;   // cl_khr_int64_base_atomics
  int compute_units;
  int work_group_max;         // work-items
  std::uint64_t local_bytes;  // of a work-group
  std::uint64_t memory_bytes;
  std::uint64_t buffer_bytes_max;
};

/// Copies between host and device since it was opened; none where they share memory.
struct TransferCounts {
  std::uint64_t uploads = 0, upload_bytes = 0;
  std::uint64_t downloads = 0, download_bytes = 0;

  TransferCounts operator-(const TransferCounts& other) const;
};

/// Every device of every platform; empty when there is none.
std::vector<DeviceInfo> list_devices();

/// Chooses the device that a selector names, as Device::open() does; unset where it names none of them.
std::optional<std::size_t> choose_device(const std::vector<DeviceInfo>& devices, const std::string& selector);

class DeviceState;
struct LaunchShape;

/// Memory on the device. Movable; released when destroyed.
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  std::size_t byte_count() const { return byte_count_; }

 private:
  friend class Device;
  friend class Kernel;
  std::shared_ptr<cl::Buffer> memory_;
  std::size_t byte_count_ = 0;
};

/// Bytes [begin, begin + count) of a buffer.
struct BufferRange {
  const DeviceBuffer* buffer;
  std::size_t begin, count;
};

struct BufferMove {
  BufferRange from;
  std::size_t to;  // first byte
};

/// A kernel of one program variant. Arguments are buffers or plain structs and numbers, in the kernel's order.
class Kernel {
 public:
  struct WorkSize {
    std::size_t global;     // work-items wanted; rounded up to a multiple of `local`, so kernels check their bounds
    std::size_t local = 0;  // 0: the device's usual size
  };

  bool is_built() const { return kernel_ != nullptr; }

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
  std::shared_ptr<cl::Kernel> kernel_;
  std::string name_;
};

/// kernels/FILE.cl in one of its variants.
struct ProgramChoice {
  std::string file;
  KernelVariant variant;
};

/// Choice of a device, and how it is used.
struct DeviceChoice {
  std::string selector;         // as Device::open() has it
  bool as_accelerator = false;  // cut work up as for a GPU whatever it is: the same bytes (LaunchShape)
};

class Device {
 public:
  /// `selector`: empty = the first GPU, else the first CPU; a number of `multum devices`; or a part of a device's or
  /// platform's name, which a number is too where no device has it: "4090". Throws Error(kEnvironment) when there is no
  /// such device, listing those there are.
  static Device open(const std::string& selector);
  static Device open(const DeviceChoice& choice);
  /// Opens the device when something is first asked of it: a driver takes 80 MiB and tens of milliseconds, and whoever
  /// refuses an input needs none. What open() throws is thrown then.
  static Device when_needed(const DeviceChoice& choice);
  bool is_open() const { return state_ != nullptr; }

  const DeviceInfo& info() const;
  /// Division of work for it (host/formats/opencl/launch_shape.h), and another one, for tests.
  const LaunchShape& shape() const;
  void set_shape(const LaunchShape& shape);

  /// Throws Error(kEnvironment) when it is larger than the device's buffers may be.
  DeviceBuffer make_buffer(std::size_t byte_count, const std::string& what);
  /// Uses the caller's memory without a copy on CPUs, copies on others; `data` must outlive the buffer and not change.
  DeviceBuffer wrap_buffer(const void* data, std::size_t byte_count, const std::string& what);
  /// Copy to and from the buffer's beginning, after the launches before.
  void write(DeviceBuffer& buffer, const void* data, std::size_t byte_count);
  void read(const DeviceBuffer& buffer, void* data, std::size_t byte_count);
  /// As write(), without waiting: `data` must stay as it is until the queue has finished.
  void queue_write(DeviceBuffer& buffer, const void* data, std::size_t byte_count);
  /// Calls `body` with where the ranges' bytes can be read, on CPUs without a copy. Waits for the launches before.
  using Bytes = std::vector<unsigned char*>;
  using WithBytes = std::function<void(const Bytes& bytes)>;
  void read_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body);
  /// Maps the ranges for writing: what `body` leaves there is in the buffers for the launches that follow. What it does
  /// not write may hold anything afterwards. Neither may be called from a `body`.
  void write_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body);
  /// Moves bytes within their buffers to a lower place, which may overlap where they are; no two moves may meet.
  void move_down(const std::vector<BufferMove>& moves);
  void fill_zero(DeviceBuffer& buffer);

  /// Begins to build these programs side by side, in their order, those that the cache lacks; kernel() waits for its
  /// own. Without a cache folder (program_cache.h) it does nothing.
  void prepare(const std::vector<ProgramChoice>& programs);
  /// A kernel of kernels/FILE.cl, built with the variant's options or taken from the program cache.
  Kernel kernel(const std::string& file, const std::string& kernel_name, const KernelVariant& variant);

  /// Edits the kernels from which programs are built from now on; an empty list ends that. Kernels made before stay as
  /// they are. For showing what a guard is for (host/lab/selftest), never for a bake.
  void edit_kernels(std::vector<SourceEdit> edits);
  bool kernels_are_edited() const;

  /// Waits for all launches.
  void finish();
  /// Hands queued launches to the device.
  void flush();

  /// Launches since it was opened, by kernel name; programs built or loaded from the cache since then. Of one job:
  /// host/formats/opencl/device_counts.h.
  const std::map<std::string, std::uint64_t>& launch_counts() const;
  std::uint64_t launch_total() const;
  int program_count() const;
  /// Programs that kernel() had to build while its caller waited: no cache had them, and nobody had prepared them.
  int unprepared_count() const;
  /// Of these, by kernels/FILE.cl.
  std::map<std::string, int> build_counts() const;
  const TransferCounts& transfers() const;
  /// Bytes of buffers that were alive, at most since it was opened or restart_buffer_peak() was called. Not those that
  /// use the host's memory.
  std::uint64_t buffer_bytes_peak() const;
  void restart_buffer_peak();

  /// Times every launch from now on, until `time_launches(false)`.
  void time_launches(bool on);
  /// Seconds on the device by kernel name, of launches that were timed. Waits for all launches.
  std::map<std::string, double> launch_seconds();
  /// Sum of these; 0 where launches are not timed.
  double timed_seconds();

 private:
  const std::shared_ptr<DeviceState>& opened() const;
  DeviceState& state() const;

  DeviceChoice choice_;
  mutable std::shared_ptr<DeviceState> state_;
};

}  // namespace multum
