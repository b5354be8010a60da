// SPDX-License-Identifier: Apache-2.0
// Copies between host and device. The buffers of a CPU are mapped without a copy. For other devices, bytes pass through
// two buffers of pinned memory, from which the device copies independently. The host fills one buffer while the other
// is copied.
#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/opencl/cl_error.h"
#include "host/formats/opencl/device.h"
#include "host/formats/opencl/device_state.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The memory of a CPU is the host's memory.
bool is_mapped(const DeviceState& state) { return state.shape.staging_bytes == 0; }

std::size_t total_of(const std::vector<BufferRange>& ranges) {
  std::size_t sum = 0;
  for (const BufferRange& range : ranges) sum += range.count;
  return sum;
}

void wait_for(cl::Event& event) {
  if (event() == nullptr) return;
  check_cl(event.wait(), "clWaitForEvents");
  event = cl::Event();
}

void release(DeviceState& state, StagingBuffer& staging) {
  if (staging.bytes != nullptr) state.queue.enqueueUnmapMemObject(staging.memory, staging.bytes);
  staging = StagingBuffer();
}

// Returns the next of the two buffers, with at least `byte_count` bytes. The caller can write to this buffer at once.
StagingBuffer& next_staging(DeviceState& state, std::size_t byte_count) {
  StagingBuffer& staging = state.staging[state.next_staging];
  state.next_staging = (state.next_staging + 1) % state.staging.size();
  wait_for(staging.copied);
  if (staging.size >= byte_count) return staging;
  release(state, staging);
  cl_int status = CL_SUCCESS;
  staging.memory = cl::Buffer(state.context, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, byte_count, nullptr, &status);
  check_cl(status, "pinned memory of " + std::to_string(byte_count) + " bytes");
  staging.bytes = static_cast<unsigned char*>(state.queue.enqueueMapBuffer(
      staging.memory, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, byte_count, nullptr, nullptr, &status));
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

// Maps ranges of CPU buffers for the host while the object exists. Ignores empty ranges. All ranges are mapped
// together, so the host waits only once for earlier launches. Later launches wait in the queue. After writing, call
// unmap(). If unmapping fails, the device may not see the bytes.
class MappedRanges {
 public:
  explicit MappedRanges(const DeviceState& state) : queue_(state.queue) {}
  ~MappedRanges() {
    for (const auto& [memory, bytes] : mapped_) queue_.enqueueUnmapMemObject(memory, bytes);
    if (!mapped_.empty()) queue_.flush();
  }
  MappedRanges(const MappedRanges&) = delete;
  MappedRanges& operator=(const MappedRanges&) = delete;

  void add(const cl::Buffer& memory, std::size_t begin, std::size_t count) {
    void* bytes = nullptr;
    if (count > 0) {
      cl_int status = CL_SUCCESS;
      bytes = queue_.enqueueMapBuffer(memory, CL_FALSE, CL_MAP_READ | CL_MAP_WRITE, begin, count, nullptr, nullptr,
                                      &status);
      check_cl(status, "clEnqueueMapBuffer");
      mapped_.emplace_back(memory, bytes);
    }
    bytes_.push_back(static_cast<unsigned char*>(bytes));
  }
  /// Waits until the host may read and write the ranges.
  const Device::Bytes& bytes() const {
    check_cl(queue_.finish(), "clFinish");
    return bytes_;
  }
  void unmap() {
    while (!mapped_.empty()) {
      const auto [memory, bytes] = mapped_.back();
      mapped_.pop_back();
      check_cl(queue_.enqueueUnmapMemObject(memory, bytes), "clEnqueueUnmapMemObject");
    }
    check_cl(queue_.flush(), "clFlush");
  }

 private:
  cl::CommandQueue queue_;
  std::vector<std::pair<cl::Buffer, void*>> mapped_;
  Device::Bytes bytes_;
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
  queue_write(buffer, data, byte_count);
  finish();
}

void Device::queue_write(DeviceBuffer& buffer, const void* data, std::size_t byte_count) {
  MULTUM_CHECK(byte_count <= buffer.byte_count_);
  if (byte_count == 0) return;
  check_cl(state().queue.enqueueWriteBuffer(*buffer.memory_, CL_FALSE, 0, byte_count, data), "clEnqueueWriteBuffer");
  state().count_upload(byte_count);
}

void Device::read(const DeviceBuffer& buffer, void* data, std::size_t byte_count) {
  MULTUM_CHECK(byte_count <= buffer.byte_count_);
  if (byte_count == 0) return;
  check_cl(state().queue.enqueueReadBuffer(*buffer.memory_, CL_TRUE, 0, byte_count, data), "clEnqueueReadBuffer");
  state().count_download(byte_count);
}

void Device::read_ranges(const std::vector<BufferRange>& ranges, const WithBytes& body) {
  for (const BufferRange& range : ranges) MULTUM_CHECK(range.begin + range.count <= range.buffer->byte_count_);
  const std::size_t total = total_of(ranges);
  if (total == 0) return;
  if (is_mapped(state())) {
    MappedRanges mapped(state());
    for (const BufferRange& range : ranges) mapped.add(*range.buffer->memory_, range.begin, range.count);
    body(mapped.bytes());
    return mapped.unmap();
  }
  const Bytes places = places_in(next_staging(state(), total).bytes, ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].count == 0) continue;
    check_cl(state().queue.enqueueReadBuffer(*ranges[i].buffer->memory_, CL_FALSE, ranges[i].begin, ranges[i].count,
                                             places[i]),
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
    check_cl(state().queue.enqueueWriteBuffer(*ranges[i].buffer->memory_, CL_FALSE, ranges[i].begin, ranges[i].count,
                                              places[i], nullptr, &staging.copied),
             "clEnqueueWriteBuffer");
    state().count_upload(ranges[i].count);
  }
  flush();  // the queue works in order, so the last copy finishes last
}

void Device::move_down(const std::vector<BufferMove>& moves) {
  for (const auto& [from, to] : moves)
    MULTUM_CHECK(to <= from.begin && from.begin + from.count <= from.buffer->byte_count_);
  if (is_mapped(state())) {
    MappedRanges mapped(state());
    for (const auto& [from, to] : moves) mapped.add(*from.buffer->memory_, to, from.begin - to + from.count);
    const Bytes& bytes = mapped.bytes();
    for (std::size_t i = 0; i < moves.size(); ++i)
      std::memmove(bytes[i], bytes[i] + (moves[i].from.begin - moves[i].to), moves[i].from.count);
    return mapped.unmap();
  }
  // Copies one piece after another. Each piece is so short that it does not overlap its target.
  for (const auto& [from, to] : moves) {
    const cl::Buffer& memory = *from.buffer->memory_;
    const std::size_t distance = from.begin - to;
    for (std::size_t done = 0; distance > 0 && done < from.count; done += distance)
      check_cl(state().queue.enqueueCopyBuffer(memory, memory, from.begin + done, to + done,
                                               std::min(distance, from.count - done)),
               "clEnqueueCopyBuffer");
  }
}

void Device::fill_zero(DeviceBuffer& buffer) {
  if (buffer.byte_count_ == 0) return;
  if (is_mapped(state())) {
    MappedRanges mapped(state());
    mapped.add(*buffer.memory_, 0, buffer.byte_count_);
    std::memset(mapped.bytes()[0], 0, buffer.byte_count_);
    return mapped.unmap();
  }
  const unsigned char zero = 0;
  check_cl(state().queue.enqueueFillBuffer(*buffer.memory_, zero, 0, buffer.byte_count_), "clEnqueueFillBuffer");
}

}  // namespace multum
