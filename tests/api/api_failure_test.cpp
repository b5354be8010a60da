// SPDX-License-Identifier: Apache-2.0
// Failure injection (after SQLite's tests): lets each allocation and each OpenCL call of a small bake fail once. Each
// failure must become an error of the call; no failure may end the process, leave a file or lose memory.
//
// The operators new and delete of this program replace those of libstdc++ for the library too. Only allocations by
// libmultum's own code are made to fail, because OpenCL drivers end the process when their allocations fail. A layer
// between the OpenCL loader and the driver makes OpenCL calls fail (failing_opencl_layer.cpp); OPENCL_LAYERS names the
// layer.
#include <dlfcn.h>
#include <execinfo.h>
#include <link.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include "tests/api/api_fixture.h"
#include "tests/fixtures/sweeps.h"

namespace {

struct CodeRange {
  std::uintptr_t begin = 0, end = 0;
};
CodeRange g_library;
std::uintptr_t g_library_base = 0;
std::atomic<bool> g_is_armed{false};
std::atomic<long> g_count{0}, g_fail_at{-1}, g_live{0}, g_failed{0};
std::atomic<std::uintptr_t> g_failed_at{0};  // code that made the allocation that failed, relative to the library

bool is_of_library(const void* caller) {
  const auto address = reinterpret_cast<std::uintptr_t>(caller);
  return address >= g_library.begin && address < g_library.end;
}

// Code of nlohmann::json. Its destructor allocates (json_value::destroy), so a failure there ends the process, and an
// exception in its constructors loses the parts that exist already. These allocations do not fail in this test.
std::vector<CodeRange>& json_code() {
  static std::vector<CodeRange> code;
  return code;
}

// Reads the functions of nlohmann::json from the symbol table. Returns false without nm or without symbols.
bool find_json_code(const char* library) {
  const std::string command = std::string("nm -S --defined-only '") + library + "'";
  std::FILE* const symbols = ::popen(command.c_str(), "r");
  if (symbols == nullptr) return false;
  unsigned long begin = 0, size = 0;
  char kind = 0, name[4096];
  char line[8192];
  while (std::fgets(line, sizeof(line), symbols) != nullptr)
    if (std::sscanf(line, "%lx %lx %c %4095s", &begin, &size, &kind, name) == 4 &&
        std::strstr(name, "nlohmann") != nullptr)
      json_code().push_back({begin, begin + size});
  ::pclose(symbols);
  return !json_code().empty();
}

bool is_in_json() {
  void* frames[48];
  const int count = ::backtrace(frames, 48);
  for (int i = 0; i < count; ++i) {
    const std::uintptr_t address = reinterpret_cast<std::uintptr_t>(frames[i]) - g_library_base;
    for (const CodeRange& range : json_code())
      if (address > range.begin && address <= range.end) return true;
  }
  return false;
}

int find_library(dl_phdr_info* info, std::size_t, void*) {
  if (std::strstr(info->dlpi_name, "libmultum.so") == nullptr) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    g_library_base = info->dlpi_addr;
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    g_library.begin = info->dlpi_addr + part.p_vaddr;
    g_library.end = g_library.begin + part.p_memsz;
  }
  return 1;
}

// Each memory block begins with a header that says whether the library allocated it.
constexpr std::size_t kHead = 64;

void* allocate(std::size_t bytes, std::size_t alignment, const void* caller) {
  const bool counts = is_of_library(caller);
  if (counts && g_is_armed) {
    if (g_count++ == g_fail_at && !is_in_json()) {
      ++g_failed;
      g_failed_at = reinterpret_cast<std::uintptr_t>(caller) - g_library_base;
      throw std::bad_alloc();
    }
  }
  const std::size_t head = alignment > kHead ? alignment : kHead;
  auto* const block = static_cast<unsigned char*>(std::aligned_alloc(head, (bytes + head + head - 1) / head * head));
  if (block == nullptr) throw std::bad_alloc();
  unsigned char* const place = block + head;
  place[-1] = counts ? 1 : 0;
  std::memcpy(place - 16, &block, sizeof(block));
  if (counts) ++g_live;
  return place;
}

void release(void* place) noexcept {
  if (place == nullptr) return;
  auto* const bytes = static_cast<unsigned char*>(place);
  if (bytes[-1] != 0) --g_live;
  void* block = nullptr;
  std::memcpy(&block, bytes - 16, sizeof(block));
  std::free(block);
}

}  // namespace

void* operator new(std::size_t bytes) { return allocate(bytes, 16, __builtin_return_address(0)); }
void* operator new[](std::size_t bytes) { return allocate(bytes, 16, __builtin_return_address(0)); }
void* operator new(std::size_t bytes, std::align_val_t a) {
  return allocate(bytes, static_cast<std::size_t>(a), __builtin_return_address(0));
}
void* operator new[](std::size_t bytes, std::align_val_t a) {
  return allocate(bytes, static_cast<std::size_t>(a), __builtin_return_address(0));
}
void operator delete(void* place) noexcept { release(place); }
void operator delete[](void* place) noexcept { release(place); }
void operator delete(void* place, std::size_t) noexcept { release(place); }
void operator delete[](void* place, std::size_t) noexcept { release(place); }
void operator delete(void* place, std::align_val_t) noexcept { release(place); }
void operator delete[](void* place, std::align_val_t) noexcept { release(place); }
void operator delete(void* place, std::size_t, std::align_val_t) noexcept { release(place); }
void operator delete[](void* place, std::size_t, std::align_val_t) noexcept { release(place); }

namespace multum::testing {
namespace {

// Bakes in memory with settings, and looks up a normal in the result. The bake has two threads, so that calls in worker
// threads fail too.
multum_status small_work(multum_device* device, const multum_image& normals, const std::string& output,
                         multum_error** error) {
  multum_values* values = nullptr;
  multum_map* map = nullptr;
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &normals;
  multum_lobes lobes;
  multum_status status = multum_values_new("bake", &values, error);
  if (status == MULTUM_OK) status = multum_values_set_number(values, "threads", 2, error);
  if (status == MULTUM_OK) status = multum_bake(device, &maps, values, output.c_str(), nullptr, &map, error);
  if (status == MULTUM_OK) status = multum_map_lookup(map, 0.5, 0.5, 1.5, &lobes, error);
  multum_map_free(map);
  multum_values_free(values);
  return status;
}

// Runs the work once for each of the given places, with a failure there, and checks what remains.
class FailureTest : public ::testing::Test {
 protected:
  void SetUp() override {
    dl_iterate_phdr(find_library, nullptr);
    ASSERT_NE(g_library.begin, 0u);
    void* frame[1];
    ::backtrace(frame, 1);  // loads what it needs before any allocation fails
    if (json_code().empty()) {
      ASSERT_TRUE(find_json_code(MULTUM_LIBRARY));
    }
    ::setenv("OPENCL_LAYERS", FAILING_LAYER, 0);  // set before the loader reads it
    device_ = open_device();
    // The first run fills caches, which stay until the process ends.
    for (int i = 0; i < 2; ++i) ASSERT_EQ(run(nullptr), MULTUM_OK);
  }

  multum_status run(multum_error** error) {
    const multum_status status = small_work(device_.get(), image_of(pixels_, 8), folder_.file("a.ndf.exr"), error);
    if (status == MULTUM_OK) std::filesystem::remove(folder_.file("a.ndf.exr"));
    return status;
  }

  // `arm` makes one call fail. `disarm` returns whether that call has failed.
  template <typename Arm, typename Disarm>
  void fail_once(long place, const Arm& arm, const Disarm& disarm) {
    const long live_before = g_live;
    {
      MadeError error;
      arm(place);
      const multum_status status = run(error.place());
      if (!disarm()) return;
      // A failure that only costs speed (a cache that cannot be read) need not be an error.
      if (status != MULTUM_OK) {
        EXPECT_EQ(error.status(), status) << "place " << place;
        EXPECT_FALSE(error.message().empty()) << "place " << place;
        EXPECT_NE(status, MULTUM_INTERNAL) << "place " << place << ": " << error.message();
        ++errors_;
      }
    }
    // The file may exist if a later step failed; then it is complete.
    const std::string file = folder_.file("a.ndf.exr");
    if (std::filesystem::exists(file)) {
      multum_map* map = nullptr;
      EXPECT_EQ(multum_map_open(file.c_str(), &map, nullptr), MULTUM_OK) << "place " << place;
      multum_map_free(map);
      std::filesystem::remove(file);
    }
    EXPECT_EQ(folder_.file_count(), 0u) << "place " << place;
    EXPECT_LE(g_live, live_before) << "place " << place << " loses memory, at libmultum.so+0x" << std::hex
                                   << g_failed_at;
    EXPECT_EQ(run(nullptr), MULTUM_OK) << "after place " << place;
  }

  TestFolder folder_;
  const std::vector<float> pixels_ = wavy_normals(8);
  Owned<multum_device> device_;
  int errors_ = 0;
};

TEST_F(FailureTest, EachAllocationFailsOnce) {
  g_count = 0;
  g_fail_at = -1;
  g_is_armed = true;
  ASSERT_EQ(run(nullptr), MULTUM_OK);
  g_is_armed = false;
  const long count = g_count;
  ASSERT_GT(count, 200);
  // All failures would take minutes, so only every n-th is tested unless MULTUM_SWEEPS=all.
  const long step = multum::testing::all_sweeps() ? 1 : std::max(1L, count / 50);
  for (long place = 0; place < count; place += step)
    fail_once(
        place,
        [](long at) {
          g_count = 0;
          g_failed = 0;
          g_fail_at = at;
          g_is_armed = true;
        },
        [] {
          g_is_armed = false;
          return g_failed > 0;
        });
  std::printf("%ld allocations, every %ld. one failed; %d errors\n", count, step, errors_);
  EXPECT_GT(10 * errors_, 8 * (count / step));  // a few failures may have another way out
}

TEST_F(FailureTest, EachOpenClCallFailsOnce) {
  void* const layer = ::dlopen(FAILING_LAYER, RTLD_NOW | RTLD_NOLOAD);
  if (layer == nullptr) GTEST_SKIP() << "this loader of OpenCL does not support layers";
  auto* const fail_at = static_cast<std::atomic<long>*>(::dlsym(layer, "failing_layer_fail_at"));
  auto* const calls = static_cast<std::atomic<long>*>(::dlsym(layer, "failing_layer_calls"));
  ASSERT_NE(fail_at, nullptr);
  *fail_at = -1;
  *calls = 0;
  ASSERT_EQ(run(nullptr), MULTUM_OK);
  const long count = *calls;
  ASSERT_GT(count, 50);
  const long step = multum::testing::all_sweeps() ? 1 : std::max(1L, count / 40);
  for (long place = 0; place < count; place += step)
    fail_once(
        place,
        [&](long at) {
          *calls = 0;
          *fail_at = at;
        },
        [&] {
          const bool failed = *calls > *fail_at;
          *fail_at = -1;
          return failed;
        });
  std::printf("%ld OpenCL calls, every %ld. one failed; %d errors\n", count, step, errors_);
  EXPECT_GT(10 * errors_, 8 * (count / step));  // a few failures may have another way out
}

}  // namespace
}  // namespace multum::testing
