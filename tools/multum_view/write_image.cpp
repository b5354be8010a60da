// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/write_image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/formats/asset/exr/picture_file.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::vector<std::uint8_t> encode_srgb(const gl::FloatImage& image, float exposure) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(image.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double linear = static_cast<double>(exposure * image.rgba[i]);
    rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(std::clamp(linear, 0.0, 1.0)))));
  }
  return rgb;
}

}  // namespace

void check_picture_path(const std::string& path) {
  if (!ends_with(path, ".png") && !ends_with(path, ".exr"))
    throw Error(ErrorCode::kUsage, path + ": has another extension, expected .png or .exr");
}

void write_picture(const std::string& path, const gl::FloatImage& image, float exposure) {
  check_picture_path(path);
  if (ends_with(path, ".png")) {
    write_png8(path, {image.width, image.height, 3, encode_srgb(image, exposure)});
  } else {
    write_exr_picture(path, image.width, image.height, image.rgba);
  }
}

}  // namespace multum
