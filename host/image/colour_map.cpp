// SPDX-License-Identifier: Apache-2.0
// The numbers' meaning: integers follow the file's colour space ("Linear", "GammaX", else sRGB, which is what an
// untagged texture is); floats are linear whatever the file says, as OpenEXR's are. NaN, infinities and negative values
// hold no reflectance: they are read as 0 and counted.
#include "host/image/colour_map.h"

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <functional>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/image/image_io.h"

namespace multum {
namespace {

struct TransferFunction {
  std::string name;
  std::function<double(double)> linear_from_encoded;
};

TransferFunction transfer_function(const RawImage& image) {
  const bool is_linear = image.colour_space == "linear" || image.colour_space == "Linear";  // readers spell both
  if (is_float_type(image.sample_type) || is_linear) return {"linear", [](double v) { return v; }};
  if (image.colour_space.starts_with("Gamma")) {
    const double gamma = std::strtod(image.colour_space.c_str() + 5, nullptr);
    // 2.2 is how PNG's gAMA spells sRGB (1 / 0.45455); others are meant as they stand.
    if (gamma > 0.0 && std::abs(gamma - 2.2) > 0.05)
      return {fmt::format("gamma {:g}", gamma), [gamma](double v) { return std::pow(v, gamma); }};
  }
  return {"sRGB", linear_from_srgb};
}

}  // namespace

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

ColourMap read_albedo_map(const std::string& path, int width, int height, int threads) {
  ImageReadSettings read_settings;
  read_settings.threads = threads;
  RawImage image = read_raw_image(path, read_settings, nullptr);
  if (image.width != width || image.height != height)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found an albedo of {} x {} texels, expected the normal map's {} x {}", path,
                            image.width, image.height, width, height));
  if (image.planes.size() == 2)
    throw Error(ErrorCode::kInput, path + ": found 2 colour channels, expected an albedo of 1 or 3");
  const TransferFunction transfer = transfer_function(image);
  std::atomic<std::int64_t> clamped_count{0};
  for_each_row_band(height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    std::int64_t clamped = 0;
    const auto begin = static_cast<std::size_t>(row_begin) * static_cast<std::size_t>(width);
    const auto end = static_cast<std::size_t>(row_end) * static_cast<std::size_t>(width);
    for (std::size_t i = begin; i < end; ++i) {
      bool is_clamped = false;
      for (std::vector<float>& plane : image.planes) {
        const bool is_valid = std::isfinite(plane[i]) && plane[i] >= 0.0f;
        is_clamped |= !is_valid;
        plane[i] = is_valid ? static_cast<float>(transfer.linear_from_encoded(static_cast<double>(plane[i]))) : 0.0f;
      }
      clamped += is_clamped ? 1 : 0;
    }
    clamped_count += clamped;
  });
  ColourMap map;
  map.width = width;
  map.height = height;
  map.format = image.format + ", " + transfer.name;
  map.clamped_count = clamped_count;
  map.r = std::move(image.planes[0]);
  map.g = image.planes.size() == 3 ? std::move(image.planes[1]) : map.r;
  map.b = image.planes.size() == 3 ? std::move(image.planes[2]) : map.r;
  return map;
}

}  // namespace multum
