// SPDX-License-Identifier: Apache-2.0
// Contains helpers for the tests of multum.h. These tests see only the installed interface of the library.
#pragma once

#include <gtest/gtest.h>
#include <multum.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace multum::testing {

struct Free {
  void operator()(multum_device* p) const { multum_device_free(p); }
  void operator()(multum_map* p) const { multum_map_free(p); }
  void operator()(multum_values* p) const { multum_values_free(p); }
  void operator()(multum_error* p) const { multum_error_free(p); }
  void operator()(multum_brdf* p) const { multum_brdf_free(p); }
  void operator()(multum_text* p) const { multum_text_free(p); }
};
template <typename Handle>
using Owned = std::unique_ptr<Handle, Free>;

/// Receives the error of a call: pass made.place() to multum_bake(), then read made.message().
class MadeError {
 public:
  ~MadeError() { multum_error_free(error_); }
  multum_error** place() { return &error_; }
  multum_status status() const { return multum_error_status(error_); }
  std::string message() const { return multum_error_message(error_); }
  std::string file() const { return multum_error_file(error_); }
  std::string found() const { return multum_error_found(error_); }
  std::string expected() const { return multum_error_expected(error_); }

 private:
  multum_error* error_ = nullptr;
};

/// Sets POCL_WORK_GROUP_METHOD if the library asks for it, as every program must (multum.h, DEVICES).
inline Owned<multum_device> open_device() {
  multum_device* device = nullptr;
  MadeError refusal, error;
  if (multum_device_open(nullptr, &device, refusal.place()) == MULTUM_OK) return Owned<multum_device>(device);
  if (refusal.expected().starts_with("POCL_WORK_GROUP_METHOD=cbs")) ::setenv("POCL_WORK_GROUP_METHOD", "cbs", 0);
  EXPECT_EQ(multum_device_open(nullptr, &device, error.place()), MULTUM_OK) << error.message();
  return Owned<multum_device>(device);
}

inline Owned<multum_values> bake_values() {
  multum_values* values = nullptr;
  EXPECT_EQ(multum_values_new("bake", &values, nullptr), MULTUM_OK);
  return Owned<multum_values>(values);
}

/// Returns the unit normals of a wavy surface that tiles, with slopes up to 0.6.
inline std::vector<float> wavy_normals(int size) {
  std::vector<float> pixels;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double s = 2.0 * M_PI * x / size, t = 2.0 * M_PI * y / size;
      const double a = 0.4 * std::sin(5.0 * s + t) + 0.2 * std::cos(11.0 * s), b = 0.3 * std::cos(3.0 * t - s);
      const double length = std::sqrt(1.0 + a * a + b * b);
      for (const double v : {-a / length, -b / length, 1.0 / length}) pixels.push_back(static_cast<float>(v));
    }
  return pixels;
}

inline multum_image image_of(const std::vector<float>& pixels, int size) {
  multum_image image = MULTUM_IMAGE_INIT;
  image.width = image.height = size;
  image.channels = 3;
  image.type = MULTUM_FLOAT;
  image.pixels = pixels.data();
  return image;
}

/// Bakes an image in memory. The settings may be null.
inline Owned<multum_map> bake(multum_device* device, const multum_image& normals, const multum_values* values,
                              const char* output = nullptr) {
  multum_maps maps = MULTUM_MAPS_INIT;
  maps.normals = &normals;
  multum_map* map = nullptr;
  MadeError error;
  EXPECT_EQ(multum_bake(device, &maps, values, output, nullptr, &map, error.place()), MULTUM_OK) << error.message();
  return Owned<multum_map>(map);
}

/// A temporary folder, which is removed at the end of the test.
class TestFolder {
 public:
  TestFolder() : path_(std::filesystem::temp_directory_path() / ("multum_api_test." + std::to_string(::getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

}  // namespace multum::testing
