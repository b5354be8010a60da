// SPDX-License-Identifier: Apache-2.0
// Tests copies between host and device. Mapped copies (as on a CPU) and plain copies (as on a GPU) must give the same
// bytes.
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>
#include <vector>

#include "host/formats/opencl/device.h"
#include "host/formats/opencl/device_counts.h"
#include "host/formats/opencl/launch_shape.h"
#include "tests/kernels/em_harness.h"

namespace multum {
namespace {

using Bytes = std::vector<unsigned char>;

class TransferTest : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (GetParam()) device_.set_shape(LaunchShape::of_accelerator(device_.info()));
  }
  void TearDown() override { device_.set_shape(LaunchShape::of(device_.info())); }
  bool copies() const { return device_.shape().staging_bytes > 0; }

  // 0 1 2 ... 255 0 1 ...
  DeviceBuffer counting(std::size_t byte_count) {
    Bytes bytes(byte_count);
    std::iota(bytes.begin(), bytes.end(), static_cast<unsigned char>(0));
    DeviceBuffer buffer = device_.make_buffer(byte_count, "counting");
    device_.write(buffer, bytes.data(), byte_count);
    return buffer;
  }
  Bytes all_of(const DeviceBuffer& buffer) {
    Bytes bytes(buffer.byte_count());
    device_.read(buffer, bytes.data(), bytes.size());
    return bytes;
  }

  Device& device_ = testing::test_device();
};

TEST_P(TransferTest, RangesOfSeveralBuffersAreWrittenAndRead) {
  DeviceBuffer first = counting(100), second = counting(50);
  const std::vector<BufferRange> ranges = {{&first, 10, 5}, {&second, 0, 3}, {&first, 90, 10}, {&second, 20, 0}};
  device_.write_ranges(ranges, [&](const Device::Bytes& at) {
    ASSERT_EQ(at.size(), 4u);
    for (std::size_t i = 0; i < 3; ++i) std::memset(at[i], static_cast<int>(200 + i), ranges[i].count);
  });
  Bytes expected_first(100), expected_second(50);
  std::iota(expected_first.begin(), expected_first.end(), static_cast<unsigned char>(0));
  std::iota(expected_second.begin(), expected_second.end(), static_cast<unsigned char>(0));
  std::fill_n(expected_first.begin() + 10, 5, static_cast<unsigned char>(200));
  std::fill_n(expected_second.begin(), 3, static_cast<unsigned char>(201));
  std::fill_n(expected_first.begin() + 90, 10, static_cast<unsigned char>(202));
  EXPECT_EQ(all_of(first), expected_first);
  EXPECT_EQ(all_of(second), expected_second);
  device_.read_ranges({{&second, 49, 1}, {&first, 88, 4}}, [&](const Device::Bytes& at) {
    EXPECT_EQ(at[0][0], 49);
    EXPECT_EQ(Bytes(at[1], at[1] + 4), Bytes({88, 89, 202, 202}));
  });
}

// Each write is larger than the pinned memory so far, and starts before the previous write is known to be done.
TEST_P(TransferTest, ManyGrowingWritesKeepTheirBytes) {
  std::vector<DeviceBuffer> buffers;
  for (std::size_t i = 0; i < 24; ++i) {
    const std::size_t size = 1000 * (i + 1);
    buffers.push_back(device_.make_buffer(size, "written"));
    device_.write_ranges({{&buffers.back(), 0, size}},
                         [&](const Device::Bytes& at) { std::memset(at[0], static_cast<int>(i + 1), size); });
  }
  for (std::size_t i = 0; i < buffers.size(); ++i)
    EXPECT_EQ(all_of(buffers[i]), Bytes(1000 * (i + 1), static_cast<unsigned char>(i + 1))) << i;
}

TEST_P(TransferTest, BytesMoveDownOverThemselves) {
  for (const std::size_t distance : {1u, 7u, 64u, 150u}) {
    const DeviceBuffer buffer = counting(256);
    Bytes expected(256);
    std::iota(expected.begin(), expected.end(), static_cast<unsigned char>(0));
    std::memmove(&expected[3], &expected[3 + distance], 100);
    device_.move_down({{{&buffer, 3 + distance, 100}, 3}});
    EXPECT_EQ(all_of(buffer), expected) << distance;
  }
}

TEST_P(TransferTest, ZerosFillABuffer) {
  DeviceBuffer buffer = counting(1000);
  device_.fill_zero(buffer);
  EXPECT_EQ(all_of(buffer), Bytes(1000, 0));
}

TEST_P(TransferTest, CopiesAreCountedWhereThereAreAny) {
  const TransferCounts before = device_.transfers();
  DeviceBuffer buffer = counting(100);
  device_.write_ranges({{&buffer, 0, 30}, {&buffer, 50, 20}}, [](const Device::Bytes&) {});
  device_.read_ranges({{&buffer, 0, 10}}, [](const Device::Bytes&) {});
  const TransferCounts counts = device_.transfers() - before;
  EXPECT_EQ(counts.uploads, copies() ? 3u : 0u);
  EXPECT_EQ(counts.upload_bytes, copies() ? 150u : 0u);
  EXPECT_EQ(counts.downloads, copies() ? 1u : 0u);
  EXPECT_EQ(counts.download_bytes, copies() ? 10u : 0u);
}

INSTANTIATE_TEST_SUITE_P(Ways, TransferTest, ::testing::Bool(),
                         [](const auto& way) { return way.param ? "copied" : "mapped"; });

TEST(LaunchShape, FollowsFromTheDevice) {
  DeviceInfo info{};
  info.is_cpu = true;
  info.memory_bytes = std::uint64_t{8} << 30;
  EXPECT_EQ(LaunchShape::of(info).vector_width, 16);
  EXPECT_EQ(LaunchShape::of(info).team_texels_max, 0u);
  EXPECT_EQ(LaunchShape::of(info).staging_bytes, 0u);
  info.is_cpu = false;
  info.compute_units = 10;
  info.work_group_max = 1024;
  info.local_bytes = 48 << 10;
  info.buffer_bytes_max = std::uint64_t{2} << 30;
  const LaunchShape shape = LaunchShape::of(info);
  EXPECT_EQ(shape.vector_width, 1);
  EXPECT_EQ(shape.local_size, 64u);
  EXPECT_GT(shape.team_texels_max, 0u);
  EXPECT_FALSE(shape.atomic_cells);
  EXPECT_EQ(shape.window_bytes_max, info.buffer_bytes_max);
  EXPECT_EQ(shape.window_bytes_useful, std::uint64_t{1} << 30);
  // Teams need work-groups of a certain size, and memory for a block of samples.
  info.work_group_max = 32;
  EXPECT_EQ(LaunchShape::of(info).team_texels_max, 0u);
  EXPECT_EQ(LaunchShape::of(info).local_size, 32u);
  info.has_atomic_longs = true;
  EXPECT_TRUE(LaunchShape::of(info).atomic_cells);
}

TEST(LaunchTimes, AreOfTheLaunchesThatWereTimed) {
  Device device = Device::open("");
  const auto launch = [&] {
    const DeviceBuffer out = device.make_buffer(1 << 16, "layout");
    device.kernel("probe_numerics", "probe_layout", {4, 1, false}).launch({1, 1}, out, 4);
    device.finish();
  };
  launch();
  EXPECT_TRUE(device.launch_seconds().empty());
  device.time_launches(true);
  launch();
  const double first = device.launch_seconds().at("probe_layout");
  EXPECT_GT(first, 0.0);
  launch();
  EXPECT_GT(device.launch_seconds().at("probe_layout"), first);
  device.time_launches(false);
  const double last = device.launch_seconds().at("probe_layout");
  launch();
  EXPECT_EQ(device.launch_seconds().at("probe_layout"), last);
}

// A process uses a device for many jobs, and each job counts its own launches.
TEST(DeviceCounts, BeginWithTheJob) {
  Device device = Device::when_needed({});
  const DeviceCounts all(device);
  EXPECT_TRUE(all.launches().empty());
  EXPECT_FALSE(device.is_open()) << "counting opens no device";
  const auto launch = [&](const char* kernel, int count) {
    for (int i = 0; i < count; ++i) {
      const DeviceBuffer out = device.make_buffer(1 << 16, "layout");
      device.kernel("probe_numerics", kernel, {4, 1, false}).launch({1, 1}, out, 4);
    }
    device.finish();
  };
  using Launches = std::map<std::string, std::uint64_t>;
  launch("probe_layout", 3);
  const DeviceCounts second(device);
  EXPECT_TRUE(second.launches().empty());
  launch("probe_layout", 2);
  EXPECT_EQ(second.launches(), (Launches{{"probe_layout", 2}}));
  EXPECT_TRUE(second.builds().empty()) << "the first job's";
  EXPECT_EQ(all.launches(), (Launches{{"probe_layout", 5}}));
  EXPECT_EQ(all.builds(), (std::map<std::string, int>{{"probe_numerics", 1}}));
}

TEST(DeviceBuffers, PeakBeginsAnew) {
  Device device = Device::open("");
  device.make_buffer(1 << 20, "large");
  const DeviceBuffer kept = device.make_buffer(1 << 10, "kept");
  EXPECT_EQ(device.buffer_bytes_peak(), std::uint64_t{1} << 20);
  device.restart_buffer_peak();
  EXPECT_EQ(device.buffer_bytes_peak(), std::uint64_t{1} << 10);
}

}  // namespace
}  // namespace multum
