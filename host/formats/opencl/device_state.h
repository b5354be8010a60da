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

/// A part of the host's memory from which the device copies data while the host continues.
struct StagingBuffer {
  cl::Buffer memory;
  unsigned char* bytes = nullptr;
  std::size_t size = 0;
  cl::Event copied;  // event after which the buffer can be overwritten; null if it already can
};

/// Byte counts of buffers, which may outlive the device's state.
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
  std::map<std::string, cl::Program> programs;  // programs by file, options and the file's edits
  std::vector<SourceEdit> edits;
  std::map<std::string, std::uint64_t> launch_counts;
  bool times_launches = false;
  std::vector<std::pair<std::string, cl::Event>> timed;  // launches with unread times
  std::map<std::string, double> launch_seconds;
  TransferCounts transfers;
  std::shared_ptr<BufferBytes> buffer_bytes = std::make_shared<BufferBytes>();
  std::array<StagingBuffer, 2> staging;  // while the device copies one, the host fills the other
  std::size_t next_staging = 0;
  int unprepared_count = 0;
  bool told_of_building = false;
  BackgroundBuilds builds;  // the last member, so that its threads end first
};

/// Returns the staging buffers to the queue that mapped them.
void release_staging(DeviceState& state);

/// Waits for all launches, and adds up their times. If this fails, no times are kept.
void collect_times(DeviceState& state);

/// Returns the key of kernels/FILE.cl, with its current edits, in state.programs.
std::string program_key(const DeviceState& state, const std::string& file, const std::string& options);

/// Builds kernels/FILE.cl with `options`, or loads a binary that was prepared or is in the cache folder.
cl::Program load_program(DeviceState& state, const std::string& file, const std::string& options);

/// Starts to build a program in the background, unless it is already available. Does nothing without a cache folder,
/// because only a binary can pass from one context to another.
void prepare_program(DeviceState& state, const std::string& file, const std::string& options);

}  // namespace multum
