// SPDX-License-Identifier: Apache-2.0
// An OpenCL device with its context, queue, programs and launch counts. No OpenCL type appears outside this folder.
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
  int index;  // number in `multum devices`
  std::string name;
  std::string platform;
  std::string driver;
  std::string version;  // version of OpenCL, with the driver's additions
  bool is_cpu;
  bool shares_memory;      // true if memory is shared with the host; avoiding copies then saves no time
  bool rounds_when_asked;  // true if divisions and roots are rounded as IEEE requires only in programs built with an
                           // option
  bool has_atomic_longs;   // true if the device has cl_khr_int64_base_atomics
  int compute_units;
  int work_group_max;         // in work-items
  std::uint64_t local_bytes;  // local memory of a work-group
  std::uint64_t memory_bytes;
  std::uint64_t buffer_bytes_max;
};

/// Counts of the copies between host and device since the device was opened. All are 0 if host and device share memory.
struct TransferCounts {
  std::uint64_t uploads = 0, upload_bytes = 0;
  std::uint64_t downloads = 0, download_bytes = 0;

  TransferCounts operator-(const TransferCounts& other) const;
};

/// Returns every device of every platform. The list may be empty.
std::vector<DeviceInfo> list_devices();

/// Chooses the device that a selector names, like Device::open(). Returns nullopt if it does not name a device.
std::optional<std::size_t> choose_device(const std::vector<DeviceInfo>& devices, const std::string& selector);

class DeviceState;
struct LaunchShape;

/// Memory on the device. The object can be moved. Its destructor frees the memory.
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
  std::size_t to;  // first byte of the target
};

/// A kernel of one program variant. Arguments are buffers, plain structs or numbers, in the order of the kernel's
/// parameters.
class Kernel {
 public:
  struct WorkSize {
    std::size_t global;     // number of work-items, rounded up to a multiple of `local`; kernels check their bounds
    std::size_t local = 0;  // 0 for the device's default
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

/// kernels/FILE.cl in one variant.
struct ProgramChoice {
  std::string file;
  KernelVariant variant;
};

/// A device and the way to use it.
struct DeviceChoice {
  std::string selector;         // as for Device::open()
  bool as_accelerator = false;  // true to divide work as for a GPU, on any device; results keep the same bytes
                                // (LaunchShape)
};

class Device {
 public:
  /// Opens a device. `selector` is empty, a number from `multum devices`, or a part of the name of a device or
  /// platform. If it is empty, opens the first GPU, or the first CPU if there is no GPU. "4090" counts as part of a
  /// name if no device has this number. If no device matches, throws Error(kEnvironment), which lists the devices.
  static Device open(const std::string& selector);
  static Device open(const DeviceChoice& choice);
  /// Opens the device when it is first used, and throws at that time like open(). A driver needs 80 MiB and tens of
  /// milliseconds, but a program that rejects its input needs no device.
  static Device when_needed(const DeviceChoice& choice);
  bool is_open() const { return state_ != nullptr; }

  const DeviceInfo& info() const;
  /// The division of work for the device (host/formats/opencl/launch_shape.h). Tests replace it with set_shape().
  const LaunchShape& shape() const;
  void set_shape(const LaunchShape& shape);

  /// Throws Error(kEnvironment) if the size exceeds the device's limit for buffers.
  DeviceBuffer make_buffer(std::size_t byte_count, const std::string& what);
  /// On CPUs, uses the caller's memory without a copy. On other devices, copies it. `data` must outlive the buffer and
  /// stay unchanged.
  DeviceBuffer wrap_buffer(const void* data, std::size_t byte_count, const std::string& what);
  /// Copies to or from the beginning of the buffer, after earlier launches have finished.
  void write(DeviceBuffer& buffer, const void* data, std::size_t byte_count);
  void read(const DeviceBuffer& buffer, void* data, std::size_t byte_count);
  /// Writes without waiting, so `data` must stay unchanged until the queue has finished.
  void queue_write(DeviceBuffer& buffer, const void* data, std::size_t byte_count);
  /// Waits for earlier launches, then calls `body` with pointers to the bytes of the ranges. On CPUs, nothing is
  /// copied.
  using Bytes = std::vector<unsigned char*>;
  using WithBytes = std::function<void(const Bytes& bytes)>;
  void read_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body);
  /// Maps the ranges for writing. Later launches see the bytes that `body` writes. Bytes that `body` does not write are
  /// undefined afterwards. `body` must not call read_ranges() or write_ranges().
  void write_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body);
  /// Moves bytes to a lower place in the same buffer. Source and target of one move may overlap, but two moves may not.
  void move_down(const std::vector<BufferMove>& moves);
  void fill_zero(DeviceBuffer& buffer);

  /// Starts to build these programs in parallel, in this order, except for those that are cached. kernel() waits for
  /// the program that it needs. Does nothing without a cache folder (program_cache.h).
  void prepare(const std::vector<ProgramChoice>& programs);
  /// Returns a kernel of kernels/FILE.cl. Its program is built with the options of the variant, or loaded from the
  /// program cache.
  Kernel kernel(const std::string& file, const std::string& kernel_name, const KernelVariant& variant);

  /// Edits the sources of programs that are built from now on. An empty list removes the edits. Existing kernels stay
  /// unchanged. Edits show what a guard prevents (host/lab/selftest). They are never used for a bake.
  void edit_kernels(std::vector<SourceEdit> edits);
  bool kernels_are_edited() const;

  /// Waits for all launches.
  void finish();
  /// Sends queued launches to the device.
  void flush();

  /// Return the number of launches by kernel name, and the number of programs built or loaded from the cache, since the
  /// device was opened. host/formats/opencl/device_counts.h counts them for one job.
  const std::map<std::string, std::uint64_t>& launch_counts() const;
  std::uint64_t launch_total() const;
  int program_count() const;
  /// Returns the number of programs that kernel() had to build while its caller waited, because they were neither
  /// cached nor prepared.
  int unprepared_count() const;
  /// Counts the same programs by kernels/FILE.cl.
  std::map<std::string, int> build_counts() const;
  const TransferCounts& transfers() const;
  /// The largest number of bytes in live buffers since the device was opened or restart_buffer_peak() was called.
  /// Buffers that use the host's memory are ignored.
  std::uint64_t buffer_bytes_peak() const;
  void restart_buffer_peak();

  /// Turns the timing of launches on or off.
  void time_launches(bool on);
  /// Returns the seconds on the device by kernel name, for timed launches. Waits for all launches.
  std::map<std::string, double> launch_seconds();
  /// Returns the sum over all timed launches, or 0 if timing is off.
  double timed_seconds();

 private:
  const std::shared_ptr<DeviceState>& opened() const;
  DeviceState& state() const;

  DeviceChoice choice_;
  mutable std::shared_ptr<DeviceState> state_;
};

}  // namespace multum
