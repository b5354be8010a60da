// SPDX-License-Identifier: Apache-2.0
// Tests the limits of containers. Uses file trees like those that kernels and container engines make, and a control
// group on this machine.
#include "host/foundation/base/processes/container_limits.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "host/foundation/base/processes/machine.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::write_bytes;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kNone = ContainerLimits::kNoMemoryLimit;
constexpr double kAll = std::numeric_limits<double>::infinity();

class ContainerLimitsTest : public ::testing::Test {
 protected:
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories(fs::path(folder_ / path).parent_path());
    write_bytes(folder_ / path, text);
  }
  void expect(std::uint64_t memory, double processors) const {
    const ContainerLimits found = container_limits(folder_.path());
    EXPECT_EQ(found.memory_bytes, memory);
    EXPECT_EQ(found.processors, processors);
  }
  testing::TemporaryFolder folder_;
};

TEST_F(ContainerLimitsTest, NothingIsNoLimit) {
  expect(kNone, kAll);
  write("proc/self/cgroup", "0::/user.slice\n");
  expect(kNone, kAll);
  write("sys/fs/cgroup/user.slice/memory.max", "max\n");
  write("sys/fs/cgroup/user.slice/memory.high", "max\n");
  write("sys/fs/cgroup/user.slice/cpu.max", "max 100000\n");
  expect(kNone, kAll);
}

TEST_F(ContainerLimitsTest, Version2HasTheLeastOfAllGroupsAbove) {
  write("proc/self/cgroup", "0::/a/b/c\n");
  write("proc/self/mountinfo", "30 24 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n");
  write("sys/fs/cgroup/a/b/c/memory.max", "max\n");
  write("sys/fs/cgroup/a/b/memory.max", std::to_string(400 * kMiB) + "\n");
  write("sys/fs/cgroup/a/memory.max", std::to_string(900 * kMiB) + "\n");
  write("sys/fs/cgroup/a/b/c/cpu.max", "max 100000\n");
  write("sys/fs/cgroup/a/cpu.max", "150000 100000\n");
  expect(400 * kMiB, 1.5);
  write("sys/fs/cgroup/a/memory.high", std::to_string(300 * kMiB) + "\n");
  expect(300 * kMiB, 1.5);
  write("sys/fs/cgroup/a/b/c/d/memory.max", std::to_string(kMiB));  // a nested group, and a sibling
  write("sys/fs/cgroup/a/other/memory.max", std::to_string(kMiB));
  expect(300 * kMiB, 1.5);
}

// In a cgroup namespace, the container's own group is "/", and its limits are at the top.
TEST_F(ContainerLimitsTest, Version2OfANamespace) {
  write("proc/self/cgroup", "0::/\n");
  write("proc/self/mountinfo", "30 24 0:26 / /sys/fs/cgroup ro,nosuid - cgroup2 cgroup rw\n");
  write("sys/fs/cgroup/memory.max", "419430400\n");
  write("sys/fs/cgroup/cpu.max", "50000 100000\n");
  expect(400 * kMiB, 0.5);
  write("proc/self/cgroup", "0::/../../elsewhere\n");  // the process was moved out of its namespace
  expect(400 * kMiB, 0.5);
}

TEST_F(ContainerLimitsTest, Version1SeesItsContainerAtTheMount) {
  write("proc/self/cgroup",
        "5:memory:/docker/a1\n4:cpu,cpuacct:/docker/a1/inner\n2:cpuset:/docker/a1\n1:name=systemd:/docker/a1\n");
  write("proc/self/mountinfo",
        "31 23 0:28 / /proc rw - proc proc rw\n"
        "35 31 0:32 /docker/a1 /sys/fs/cgroup/memory ro,relatime - cgroup cgroup rw,memory\n"
        "36 31 0:33 /docker/a1 /sys/fs/my\\040groups ro,relatime master:3 - cgroup cgroup rw,cpu,cpuacct\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", std::to_string(512 * kMiB) + "\n");
  write("sys/fs/my groups/cpu.cfs_quota_us", "-1\n");
  write("sys/fs/my groups/cpu.cfs_period_us", "100000\n");
  write("sys/fs/my groups/inner/cpu.cfs_quota_us", "250000\n");
  write("sys/fs/my groups/inner/cpu.cfs_period_us", "100000\n");
  expect(512 * kMiB, 2.5);
  write("sys/fs/cgroup/memory/memory.stat",
        "cache 4096\nhierarchical_memory_limit " + std::to_string(256 * kMiB) + "\nhierarchical_memsw_limit 1\n");
  expect(256 * kMiB, 2.5);
}

TEST_F(ContainerLimitsTest, Version1NestedWithoutANamespace) {
  write("proc/self/cgroup", "5:memory:/slurm/job_7/step_0\n4:cpu:/slurm/job_7\n");
  write("proc/self/mountinfo",
        "35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n"
        "36 31 0:33 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/memory/slurm/job_7/memory.limit_in_bytes", std::to_string(128 * kMiB) + "\n");
  write("sys/fs/cgroup/memory/slurm/job_7/step_0/memory.limit_in_bytes", "9223372036854771712\n");
  write("sys/fs/cgroup/cpu/slurm/cpu.cfs_quota_us", "300000\n");
  write("sys/fs/cgroup/cpu/slurm/cpu.cfs_period_us", "100000\n");
  expect(128 * kMiB, 3.0);
}

// Controllers may be in either hierarchy.
TEST_F(ContainerLimitsTest, BothVersionsAtOnce) {
  write("proc/self/cgroup", "4:memory:/job\n0::/job\n");
  write("proc/self/mountinfo",
        "35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n"
        "41 31 0:38 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n");
  write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", std::to_string(700 * kMiB) + "\n");
  write("sys/fs/cgroup/unified/job/cpu.max", "200000 100000\n");
  expect(700 * kMiB, 2.0);
}

TEST_F(ContainerLimitsTest, GarbageIsNoLimit) {
  write("proc/self/cgroup", "nonsense\n\n:\n::\n0:\n0::/a\n7:memory\n5:memory:/a\n");
  write("proc/self/mountinfo",
        "\nnonsense\n1 2 3\n35 31 0:32 / /sys/fs/cgroup/memory rw - cgroup\n35 31 0:32 / /m\\999 rw - cgroup c "
        "rw,memory\n");
  for (const char* text : {"", "\n", "abc", "-5", "12x", "0", "1e9", "99999999999999999999999999", "max max"}) {
    SCOPED_TRACE(text);
    write("sys/fs/cgroup/a/memory.max", text);
    write("sys/fs/cgroup/a/cpu.max", text);
    write("m\\999/a/memory.limit_in_bytes", text);
    expect(kNone, kAll);
  }
  write("sys/fs/cgroup/a/cpu.max", "100000");  // no period
  expect(kNone, kAll);
  write("sys/fs/cgroup/a/cpu.max", "100000 0");
  expect(kNone, kAll);
  fs::remove(folder_ / "sys/fs/cgroup/a/memory.max");
  fs::create_directory(folder_ / "sys/fs/cgroup/a/memory.max");
  expect(kNone, kAll);
}

// Makes a control group (version 1) below this process's own group, and puts a child of this process into it.
TEST(ContainerLimitsOfThisMachineTest, ARealGroupIsHonoured) {
  std::string own;
  std::ifstream in("/proc/self/cgroup");
  for (std::string line; std::getline(in, line);)
    if (const std::size_t at = line.find(":memory:"); at != std::string::npos) own = line.substr(at + 8);
  const fs::path group = fs::path("/sys/fs/cgroup/memory" + own) / ("multum_test_" + std::to_string(::getpid()));
  std::error_code error;
  if (own.empty() || !fs::create_directory(group, error))
    GTEST_SKIP() << "cannot create a version 1 group here: " << error.message();
  std::ofstream(group / "memory.limit_in_bytes") << 400 * kMiB;
  const pid_t child = ::fork();
  if (child == 0) {
    std::ofstream(group / "cgroup.procs") << ::getpid() << std::flush;
    ::_exit(container_limits("").memory_bytes == 400 * kMiB ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  ::rmdir(group.c_str());
  EXPECT_EQ(status, 0);
}

TEST(ProcessorCountTest, IsWhatThisProcessMayUse) {
  EXPECT_GT(machine_memory_bytes(), 64 * kMiB);
  cpu_set_t before, one;
  ASSERT_EQ(::sched_getaffinity(0, sizeof(before), &before), 0);
  const int all = CPU_COUNT(&before);
  EXPECT_EQ(processor_count({}), all);
  EXPECT_EQ(processor_count({kNone, 0.1}), 1);
  EXPECT_EQ(processor_count({kNone, 1.5}), std::min(all, 2)) << "rounded up";
  EXPECT_EQ(processor_count({kNone, 1e30}), all);
  int first = 0;
  while (!CPU_ISSET(first, &before)) ++first;
  CPU_ZERO(&one);
  CPU_SET(first, &one);
  ASSERT_EQ(::sched_setaffinity(0, sizeof(one), &one), 0);  // acts as a cpuset does
  EXPECT_EQ(processor_count({}), 1);
  ASSERT_EQ(::sched_setaffinity(0, sizeof(before), &before), 0);
}

}  // namespace
}  // namespace multum
