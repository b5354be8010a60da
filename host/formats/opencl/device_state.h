// SPDX-License-Identifier: Apache-2.0
// State that a Device and its kernels share. Private to host/formats/opencl.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/opencl/background_builds.h"
#include "host/formats/opencl/cl_headers.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/launch_shape.h"

namespace multum {

/// Host memory that the device copies from by itself, while the host goes on.
struct StagingBuffer {
  cl::Buffer memory;
  unsigned char* bytes = nullptr;
  std::size_t size = 0;
  cl::Event copied;  // when it may be written again; none: now
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
  cl::Device device;
  cl::Context context;
  cl::CommandQueue queue;
  std::map<std::string, cl::Program> programs;  // by file, options and edits of the file
  std::vector<SourceEdit> edits;
  std::map<std::string, std::uint64_t> launch_counts;
  bool times_launches = false;
  std::vector<std::pair<std::string, cl::Event>> timed;  // launches whose times are still to be asked for
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
cl::Program load_program(DeviceState& state, const std::string& file, const std::string& options);

/// Begins to build it, unless it is there already or there is no cache folder, whose binaries alone can be handed from
/// one context to another.
void prepare_program(DeviceState& state, const std::string& file, const std::string& options);

}  // namespace multum
