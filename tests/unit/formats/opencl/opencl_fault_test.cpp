// SPDX-License-Identifier: Apache-2.0
// Tests the choice of devices and failing OpenCL calls: every object is released exactly once, and no failure is
// ignored. The functions below replace the functions of the library. They call the original functions until one of them
// is told to fail.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "kernels/shared/mip_box.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace {

constexpr int kOutOfResources = -5;

int g_events_released = 0, g_queues = 0;
int g_times_until_failure = -1;  // number of successful calls of clGetEventProfilingInfo; -1 if all succeed
bool g_unmap_fails = false;

template <typename Function>
Function* library_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// The types are those of CL/cl.h: handles are pointers, and cl_bitfield has 64 bits.
extern "C" {

int clReleaseEvent(void* event) {
  ++g_events_released;
  return library_function<int(void*)>("clReleaseEvent")(event);
}

void* clCreateCommandQueue(void* context, void* device, std::uint64_t properties, int* status) {
  ++g_queues;
  return library_function<void*(void*, void*, std::uint64_t, int*)>("clCreateCommandQueue")(context, device, properties,
                                                                                            status);
}

int clReleaseCommandQueue(void* queue) {
  --g_queues;
  return library_function<int(void*)>("clReleaseCommandQueue")(queue);
}

int clGetEventProfilingInfo(void* event, unsigned what, std::size_t size, void* value, std::size_t* needed) {
  if (g_times_until_failure == 0) return kOutOfResources;
  if (g_times_until_failure > 0) --g_times_until_failure;
  return library_function<int(void*, unsigned, std::size_t, void*, std::size_t*)>("clGetEventProfilingInfo")(
      event, what, size, value, needed);
}

int clEnqueueUnmapMemObject(void* queue, void* memory, void* mapped, unsigned count, void* const* events,
                            void** event) {
  const int status = library_function<int(void*, void*, void*, unsigned, void* const*, void**)>(
      "clEnqueueUnmapMemObject")(queue, memory, mapped, count, events, event);
  return g_unmap_fails ? kOutOfResources : status;
}

}  // extern "C"

namespace multum {
namespace {

class OpenclFaultTest : public ::testing::Test {
 protected:
  OpenclFaultTest() { g_events_released = 0, g_queues = 0, g_times_until_failure = -1, g_unmap_fails = false; }

  // Launches a kernel that copies a texel, `times` times.
  static void launch(Device& device, int times) {
    MultumBoxBand band{};
    band.map_width = band.map_height = band.row_count = band.row_length = band.plane_count = 1;
    Kernel kernel = device.kernel("mip_box", "mip_texels", KernelVariant{1, 1, false});
    DeviceBuffer from = device.make_buffer(4, "planes"), to = device.make_buffer(4, "nodes");
    for (int i = 0; i < times; ++i) kernel.launch({1}, from, to, band);
    device.finish();
  }
};

TEST_F(OpenclFaultTest, EventsAreReleasedOnceWhenATimeCannotBeHad) {
  {
    Device device = Device::open("");
    device.time_launches(true);
    launch(device, 3);
    const int before = g_events_released;
    g_times_until_failure = 2;  // the calls of the first launch
    testing::expect_error(ErrorCode::kEnvironment, {"mip_texels", "CL_OUT_OF_RESOURCES"},
                          [&] { device.launch_seconds(); });
    EXPECT_EQ(g_events_released - before, 3);
    g_times_until_failure = -1;
    EXPECT_EQ(device.launch_seconds().size(), 1u) << "what could be had";
    launch(device, 1);
    device.launch_seconds();
    EXPECT_EQ(g_events_released - before, 4);
    g_events_released = 0;
  }
  EXPECT_EQ(g_events_released, 0) << "no event is left for the device to release";
}

TEST_F(OpenclFaultTest, AQueueIsReleasedWhenTimesCannotBeHad) {
  {
    Device device = Device::open("");
    device.time_launches(true);
    launch(device, 1);
    g_times_until_failure = 0;
    EXPECT_THROW(device.time_launches(false), Error);
    EXPECT_EQ(g_queues, 1) << "the new queue was released, and the old one is still in use";
    g_times_until_failure = -1;
    device.time_launches(false);
    launch(device, 1);
  }
  EXPECT_EQ(g_queues, 0);
}

TEST_F(OpenclFaultTest, AnUnmapThatFailsIsAnError) {
  Device device = Device::open("");
  if (!device.info().is_cpu) GTEST_SKIP() << "buffers of " << device.info().name << " are copied, not mapped";
  DeviceBuffer buffer = device.make_buffer(64, "numbers");
  device.fill_zero(buffer);
  g_unmap_fails = true;
  const std::vector<std::string> said = {"clEnqueueUnmapMemObject", "CL_OUT_OF_RESOURCES"};
  testing::expect_error(ErrorCode::kEnvironment, said, [&] { device.fill_zero(buffer); });
  testing::expect_error(ErrorCode::kEnvironment, said, [&] {
    device.write_ranges({{&buffer, 0, 4}, {&buffer, 8, 4}}, [](const Device::Bytes& bytes) { bytes[0][0] = 1; });
  });
  testing::expect_error(ErrorCode::kEnvironment, said, [&] { device.move_down({{{&buffer, 8, 4}, 0}}); });
  EXPECT_THROW(device.read_ranges({{&buffer, 0, 4}}, [](const Device::Bytes&) { throw Cancelled(); }), Cancelled)
      << "the reader's exception must be thrown";
}

std::vector<DeviceInfo> devices_called(const std::vector<std::string>& names) {
  std::vector<DeviceInfo> devices;
  for (const std::string& name : names) {
    DeviceInfo info{};
    info.index = static_cast<int>(devices.size());
    info.name = name;
    info.platform = name.starts_with("cpu") ? "Portable Computing Language" : "NVIDIA CUDA";
    info.is_cpu = name.starts_with("cpu");
    devices.push_back(info);
  }
  return devices;
}

// A number is the index of a device if the list has this index. Otherwise it is a part of a name.
TEST(ChooseDeviceTest, NumbersAreOfTheListOrOfNames) {
  const std::vector<DeviceInfo> devices =
      devices_called({"cpu-haswell-i7-4770", "NVIDIA GeForce RTX 4090", "NVIDIA GeForce GTX 1080", "NVIDIA 1"});
  EXPECT_EQ(choose_device(devices, "4090"), 1u);
  EXPECT_EQ(choose_device(devices, "1080"), 2u);
  EXPECT_EQ(choose_device(devices, "4770"), 0u);
  EXPECT_EQ(choose_device(devices, "1"), 1u) << "the list comes first";
  EXPECT_EQ(choose_device(devices, "3"), 3u);
  EXPECT_EQ(choose_device(devices, "01"), std::nullopt);
  EXPECT_EQ(choose_device(devices, "5000"), std::nullopt);
  EXPECT_EQ(choose_device(devices, "NVIDIA"), 1u);
  EXPECT_EQ(choose_device(devices, "Portable"), 0u);
  EXPECT_EQ(choose_device(devices, ""), 1u) << "the first GPU";
}

}  // namespace
}  // namespace multum
