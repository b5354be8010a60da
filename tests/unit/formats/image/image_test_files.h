// SPDX-License-Identifier: Apache-2.0
// Writes image files for tests through OpenImageIO.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <glm/vec3.hpp>

#include "host/formats/image/normals/normal_map.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

struct TestImage {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<float> values = {};  // interleaved
  OIIO::TypeDesc type = OIIO::TypeDesc::UINT8;
  std::vector<std::string> channel_names = {};  // if empty, OpenImageIO chooses the names
  int alpha_channel = -1;
  int tile_size = 0;  // 0 means scan lines
  std::string compression = "";
  std::string colour_space = "";

  float& at(int column, int row, int channel) {
    return values[static_cast<std::size_t>((row * width + column) * channels + channel)];
  }
};

/// Writes the file. Fails the test if OpenImageIO cannot write it.
void write_test_image(const std::string& path, const TestImage& image);

/// Returns the unit normals of a periodic surface without symmetries, with +Y up. `steepness` is about the rms slope.
std::vector<glm::dvec3> surface_normals(int width, int height, double steepness = 0.4);

/// Returns normals as the values of a file with three channels, which are 0..1 unless `is_signed`. A `green_sign` of -1
/// is the convention of DirectX.
TestImage normal_image(int width, int height, bool is_signed = false, double green_sign = 1.0);

/// Returns the largest distance between a normal of the map and the expected normal.
double largest_difference(const NormalMap& map, const std::vector<glm::dvec3>& normals);

/// Reads a map with two threads and without progress.
NormalMap read_map(const std::string& path, const NormalMapSettings& settings = {});

}  // namespace multum::testing
