// SPDX-License-Identifier: Apache-2.0
#include "host/api/api_device.h"

#include <chrono>
#include <cstdlib>
#include <memory>
#include <mutex>

#include "host/api/api_call.h"
#include "host/api/api_error.h"
#include "host/formats/opencl/kernel_caches.h"

namespace multum {
namespace {

const char* environment(const char* name) { return std::getenv(name); }

// Compiled kernels are stored in the same place where `multum` stores them.
void use_kernel_caches() {
  static std::once_flag once;
  std::call_once(once, [] { set_kernel_caches(kernel_cache_folders(environment)); });
}

}  // namespace

DeviceUse::DeviceUse(multum_device& device, Progress* progress) : device_(device) {
  constexpr std::chrono::milliseconds kBetweenReports{100};
  if (device.user == std::this_thread::get_id())
    throw Error(ErrorCode::kUsage, "a callback has used the device of the running call, expected another device");
  while (!device.mutex.try_lock_for(kBetweenReports)) progress_stage(progress, "wait for the device");
  device.user = std::this_thread::get_id();
}

DeviceUse::~DeviceUse() {
  device_.user = std::thread::id();
  device_.mutex.unlock();
}

}  // namespace multum

multum_status multum_device_open(const char* selector, multum_device** device, multum_error** error) {
  return multum::guarded(error, [&] {
    multum::require(device, "multum_device_open", "device", "a place for the result");
    const multum::ApiCall call(nullptr);
    multum::use_kernel_caches();
    multum::Device opened = multum::Device::open(selector == nullptr ? "" : selector);
    auto made = std::make_unique<multum_device>();
    made->name = opened.info().name;
    made->device = std::move(opened);
    *device = made.release();
  });
}

const char* multum_device_name(const multum_device* device) { return device == nullptr ? "" : device->name.c_str(); }

void multum_device_free(multum_device* device) { delete device; }

multum_status multum_list_devices(void (*each)(void* user, int index, const char* name, const char* platform),
                                  void* user, multum_error** error) {
  return multum::guarded(error, [&] {
    multum::require(reinterpret_cast<const void*>(each), "multum_list_devices", "each", "a function");
    const multum::ApiCall call(nullptr);
    multum::use_kernel_caches();
    for (const multum::DeviceInfo& info : multum::list_devices())
      each(user, info.index, info.name.c_str(), info.platform.c_str());
  });
}
