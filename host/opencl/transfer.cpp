// SPDX-License-Identifier: Apache-2.0
// Copies between host and device. A CPU's buffers are mapped, without a copy. For others bytes pass through pinned
// memory, from which the device copies by itself: the host fills one buffer while the other one is on its way.
#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "host/base/error.h"
#include "host/opencl/cl_error.h"
#include "host/opencl/device.h"
#include "host/opencl/device_state.h"

namespace multum {
namespace {

// A CPU's memory is the host's.
bool is_mapped(const DeviceState& state) { return state.shape.staging_bytes == 0; }

std::size_t total_of(const std::vector<BufferRange>& ranges) {
  std::size_t sum = 0;
  for (const BufferRange& range : ranges) sum += range.count;
  return sum;
}

void wait_for(cl_event& event) {
  if (event == nullptr) return;
  check_cl(clWaitForEvents(1, &event), "clWaitForEvents");
  clReleaseEvent(event);
  event = nullptr;
}

void release(DeviceState& state, StagingBuffer& staging) {
  if (staging.copied != nullptr) clReleaseEvent(staging.copied);
  if (staging.bytes != nullptr)
    clEnqueueUnmapMemObject(state.queue, staging.memory, staging.bytes, 0, nullptr, nullptr);
  if (staging.memory != nullptr) clReleaseMemObject(staging.memory);
  staging = StagingBuffer();
}

// The next of the two, free to be written, of at least so many bytes.
StagingBuffer& next_staging(DeviceState& state, std::size_t byte_count) {
  StagingBuffer& staging = state.staging[state.next_staging];
  state.next_staging = (state.next_staging + 1) % state.staging.size();
  wait_for(staging.copied);
  if (staging.size >= byte_count) return staging;
  release(state, staging);
  cl_int status = CL_SUCCESS;
  staging.memory =
      clCreateBuffer(state.context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, byte_count, nullptr, &status);
  check_cl(status, "pinned memory of " + std::to_string(byte_count) + " bytes");
  staging.bytes = static_cast<unsigned char*>(clEnqueueMapBuffer(
      state.queue, staging.memory, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, byte_count, 0, nullptr, nullptr, &status));
  check_cl(status, "clEnqueueMapBuffer of pinned memory");
  staging.size = byte_count;
  return staging;
}

Device::Bytes places_in(unsigned char* bytes, const std::vector<BufferRange>& ranges) {
  Device::Bytes places;
  for (const BufferRange& range : ranges) {
    places.push_back(bytes);
    bytes += range.count;
  }
  return places;
}

cl_mem memory_of(const std::shared_ptr<void>& memory) { return static_cast<cl_mem>(memory.get()); }

// A range of a CPU's buffer as the host sees it, until it goes.
class MappedRange {
 public:
  MappedRange(const DeviceState& state, cl_mem memory, std::size_t begin, std::size_t count)
      : queue_(state.queue), memory_(memory) {
    cl_int status = CL_SUCCESS;
    bytes_ = clEnqueueMapBuffer(queue_, memory, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, begin, count, 0, nullptr, nullptr,
                                &status);
    check_cl(status, "clEnqueueMapBuffer");
  }
  ~MappedRange() {
    clEnqueueUnmapMemObject(queue_, memory_, bytes_, 0, nullptr, nullptr);
    clFinish(queue_);
  }
  MappedRange(const MappedRange&) = delete;
  MappedRange& operator=(const MappedRange&) = delete;

  unsigned char* bytes() const { return static_cast<unsigned char*>(bytes_); }

 private:
  cl_command_queue queue_;
  cl_mem memory_;
  void* bytes_;
};

}  // namespace

TransferCounts TransferCounts::operator-(const TransferCounts& other) const {
  return {uploads - other.uploads, upload_bytes - other.upload_bytes, downloads - other.downloads,
          download_bytes - other.download_bytes};
}

void release_staging(DeviceState& state) {
  for (StagingBuffer& staging : state.staging) release(state, staging);
}

const TransferCounts& Device::transfers() const { return state().transfers; }

void Device::write(DeviceBuffer& buffer, const void* data, std::size_t byte_count) {
  MULTUM_CHECK(byte_count <= buffer.byte_count_);
  if (byte_count == 0) return;
  check_cl(clEnqueueWriteBuffer(state().queue, static_cast<cl_mem>(buffer.memory_.get()), CL_TRUE, 0, byte_count, data,
                                0, nullptr, nullptr),
           "clEnqueueWriteBuffer");
  state().count_upload(byte_count);
}

void Device::read(const DeviceBuffer& buffer, void* data, std::size_t byte_count) {
  MULTUM_CHECK(byte_count <= buffer.byte_count_);
  if (byte_count == 0) return;
  check_cl(clEnqueueReadBuffer(state().queue, static_cast<cl_mem>(buffer.memory_.get()), CL_TRUE, 0, byte_count, data,
                               0, nullptr, nullptr),
           "clEnqueueReadBuffer");
  state().count_download(byte_count);
}

namespace {

// Ranges of CPUs' buffers: `map(i)` maps one that holds anything.
template <typename Map>
void with_mapped(const std::vector<BufferRange>& ranges, const Map& map, const Device::WithBytes& body) {
  std::vector<std::unique_ptr<MappedRange>> mapped;
  Device::Bytes places;
  for (const BufferRange& range : ranges) {
    mapped.push_back(range.count == 0 ? nullptr : map(range));
    places.push_back(range.count == 0 ? nullptr : mapped.back()->bytes());
  }
  body(places);
}

}  // namespace

void Device::read_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body) {
  for (const BufferRange& range : ranges) MULTUM_CHECK(range.begin + range.count <= range.buffer->byte_count_);
  const std::size_t total = total_of(ranges);
  if (total == 0) return;
  const auto map = [&](const BufferRange& range) {
    return std::make_unique<MappedRange>(state(), memory_of(range.buffer->memory_), range.begin, range.count);
  };
  if (is_mapped(state())) return with_mapped(ranges, map, body);
  const Bytes places = places_in(next_staging(state(), total).bytes, ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].count == 0) continue;
    check_cl(clEnqueueReadBuffer(state().queue, memory_of(ranges[i].buffer->memory_), CL_FALSE, ranges[i].begin,
                                 ranges[i].count, places[i], 0, nullptr, nullptr),
             "clEnqueueReadBuffer");
    state().count_download(ranges[i].count);
  }
  finish();
  body(places);
}

void Device::write_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body) {
  if (is_mapped(state())) return read_ranges(ranges, body);
  for (const BufferRange& range : ranges) MULTUM_CHECK(range.begin + range.count <= range.buffer->byte_count_);
  const std::size_t total = total_of(ranges);
  if (total == 0) return;
  StagingBuffer& staging = next_staging(state(), total);
  const Bytes places = places_in(staging.bytes, ranges);
  body(places);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].count == 0) continue;
    if (staging.copied != nullptr) clReleaseEvent(std::exchange(staging.copied, nullptr));
    check_cl(clEnqueueWriteBuffer(state().queue, memory_of(ranges[i].buffer->memory_), CL_FALSE, ranges[i].begin,
                                  ranges[i].count, places[i], 0, nullptr, &staging.copied),
             "clEnqueueWriteBuffer");
    state().count_upload(ranges[i].count);
  }
  flush();  // the last copy's end is the end of all: the queue keeps its order
}

void Device::move_down(const BufferRange& from, std::size_t to) {
  MULTUM_CHECK(to <= from.begin && from.begin + from.count <= from.buffer->byte_count_);
  if (from.count == 0 || to == from.begin) return;
  const cl_mem memory = memory_of(from.buffer->memory_);
  const std::size_t distance = from.begin - to;
  if (is_mapped(state())) {
    const MappedRange mapped(state(), memory, to, distance + from.count);
    std::memmove(mapped.bytes(), mapped.bytes() + distance, from.count);
    return;
  }
  // In pieces that do not overlap what they are copied to, one after another.
  for (std::size_t done = 0; done < from.count; done += distance)
    check_cl(clEnqueueCopyBuffer(state().queue, memory, memory, from.begin + done, to + done,
                                 std::min(distance, from.count - done), 0, nullptr, nullptr),
             "clEnqueueCopyBuffer");
}

void Device::fill_zero(DeviceBuffer& buffer) {
  if (buffer.byte_count_ == 0) return;
  const auto memory = static_cast<cl_mem>(buffer.memory_.get());
  if (is_mapped(state())) {
    const MappedRange mapped(state(), memory, 0, buffer.byte_count_);
    std::memset(mapped.bytes(), 0, buffer.byte_count_);
    return;
  }
  const unsigned char zero = 0;
  check_cl(clEnqueueFillBuffer(state().queue, memory, &zero, 1, 0, buffer.byte_count_, 0, nullptr, nullptr),
           "clEnqueueFillBuffer");
}

}  // namespace multum
