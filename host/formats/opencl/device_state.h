// SPDX-License-Identifier: Apache-2.0
// State that a Device and its kernels share. Private to host/formats/opencl.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/formats/opencl/background_builds.h"
#include "host/formats/opencl/cl_headers.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/launch_shape.h"

namespace multum {

struct EventRelease {
  void operator()(cl_event event) const { clReleaseEvent(event); }
};
using EventHandle = std::unique_ptr<std::remove_pointer_t<cl_event>, EventRelease>;

struct QueueRelease {
  void operator()(cl_command_queue queue) const { clReleaseCommandQueue(queue); }
};
using QueueHandle = std::unique_ptr<std::remove_pointer_t<cl_command_queue>, QueueRelease>;

/// Host memory that the device copies from by itself, while the host goes on.
struct StagingBuffer {
  cl_mem memory = nullptr;
  unsigned char* bytes = nullptr;
  std::size_t size = 0;
  EventHandle copied;  // when it may be written again; null: now
};

/// Bytes of buffers, which may outlive the device's state.
struct BufferBytes {
  std::uint64_t now = 0, peak = 0;
};

class DeviceState {
 public:
  DeviceState() = default;
  ~DeviceState();
  DeviceState(const DeviceState&) = delete;
  DeviceState& operator=(const DeviceState&) = delete;

  void count_upload(std::size_t bytes) {
    if (shape.staging_bytes == 0) return;
    ++transfers.uploads;
    transfers.upload_bytes += bytes;
  }
  void count_download(std::size_t bytes) {
    if (shape.staging_bytes == 0) return;
    ++transfers.downloads;
    transfers.download_bytes += bytes;
  }

  DeviceInfo info;
  LaunchShape shape{};
  cl_device_id device = nullptr;
  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
  std::map<std::string, cl_program> programs;  // by file, options and edits of the file
  std::vector<SourceEdit> edits;
  std::map<std::string, std::uint64_t> launch_counts;
  bool times_launches = false;
  std::vector<std::pair<std::string, EventHandle>> timed;  // launches whose times are still to be asked for
  std::map<std::string, double> launch_seconds;
  TransferCounts transfers;
  std::shared_ptr<BufferBytes> buffer_bytes = std::make_shared<BufferBytes>();
  std::array<StagingBuffer, 2> staging;  // one is filled while the other one is copied
  std::size_t next_staging = 0;
  int unprepared_count = 0;
  bool told_of_building = false;
  BackgroundBuilds builds;  // last: its threads end before the rest goes
};

/// Gives the staging buffers back to the queue that mapped them.
void release_staging(DeviceState& state);

/// Adds up the times of launches that have ended; waits for those that have not. When it throws, no times are left.
void collect_times(DeviceState& state);

/// Key of kernels/FILE.cl in state.programs, as it is now edited.
std::string program_key(const DeviceState& state, const std::string& file, const std::string& options);

/// Builds kernels/FILE.cl with `options`, or loads the binary that is prepared or that an earlier run left in the cache
/// folder.
cl_program load_program(DeviceState& state, const std::string& file, const std::string& options);

/// Begins to build it, unless it is there already or there is no cache folder, whose binaries alone can be handed from
/// one context to another.
void prepare_program(DeviceState& state, const std::string& file, const std::string& options);

}  // namespace multum
