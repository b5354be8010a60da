// SPDX-License-Identifier: Apache-2.0
// Interprets values as colours. Integers are in the colour space of the file ("Linear", "GammaX", otherwise sRGB, as
// for untagged textures). Floats are always linear, as in OpenEXR. NaN, infinities and negative values are not
// reflectances, so they become 0 and are counted. Texels are independent, so every band is converted as soon as it is
// read.
#include "host/formats/image/colour_map.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "host/formats/image/image_reader.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/leading_number.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

struct TransferFunction {
  std::string name;
  std::function<double(double)> linear_from_encoded;
};

TransferFunction transfer_function(const RawImageInfo& image, ColourEncoding encoding) {
  if (encoding == ColourEncoding::kSrgb) return {"sRGB", linear_from_srgb};
  if (encoding == ColourEncoding::kLinear) return {"linear", [](double v) { return v; }};
  const bool is_linear =
      image.colour_space == "linear" || image.colour_space == "Linear";  // both spellings occur in files
  if (is_float_type(image.sample_type) || is_linear) return {"linear", [](double v) { return v; }};
  if (image.colour_space.starts_with("Gamma")) {
    const double gamma = leading_number(image.colour_space.substr(5)).value_or(0.0);
    // An exponent of 2.2 means sRGB in PNG's gAMA (1 / 0.45455). Other exponents are used unchanged.
    if (gamma > 0.0 && std::abs(gamma - 2.2) > 0.05)
      return {fmt::format("gamma {:g}", gamma), [gamma](double v) { return std::pow(v, gamma); }};
  }
  return {"sRGB", linear_from_srgb};
}

void check_channels(const std::string& path, const RawImageInfo& info) {
  if (info.channel_count == 2) throw Error(ErrorCode::kInput, path + ": found 2 colour channels, expected 1 or 3");
}

void check_albedo_size(const std::string& path, const RawImageInfo& info, int width, int height) {
  if (info.width != width || info.height != height)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found an albedo of {} x {} texels, expected {} x {} as in the normal map", path,
                            info.width, info.height, width, height));
}

// Converts samples to linear colours; gives NaN for a sample that is not a reflectance.
SampleConverter linear_converter(int base_type, const TransferFunction& transfer) {
  return SampleConverter(base_type, [linear = transfer.linear_from_encoded](float v) {
    return std::isfinite(v) && v >= 0.0f ? static_cast<float>(linear(static_cast<double>(v)))
                                         : std::numeric_limits<float>::quiet_NaN();
  });
}

// Keeps the values; gives NaN for a sample that is not finite.
SampleConverter data_converter(int base_type) {
  return SampleConverter(base_type,
                         [](float v) { return std::isfinite(v) ? v : std::numeric_limits<float>::quiet_NaN(); });
}

// Splits a row of interleaved colours into planes, and replaces NaN by 0. Returns the number of affected texels.
std::int64_t separate_row(const std::vector<float>& values, const std::array<float*, 3>& row,
                          std::size_t channel_count) {
  std::int64_t clamped_count = 0;
  for (std::size_t i = 0; i * channel_count < values.size(); ++i) {
    bool is_clamped = false;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const float v = values[i * channel_count + (channel_count == 3 ? c : 0)];
      is_clamped |= std::isnan(v);
      row[c][i] = std::isnan(v) ? 0.0f : v;
    }
    clamped_count += is_clamped ? 1 : 0;
  }
  return clamped_count;
}

ImageReadSettings reading_settings(const SpillPolicy& spill, int threads) {
  ImageReadSettings settings;
  settings.threads = threads;
  settings.band_rows = spill.band_rows;
  return settings;
}

ColourRows read_rows(ImageReader& reader, const std::string& path, ColourEncoding encoding, const SpillPolicy& spill,
                     int threads, Progress* progress) {
  const RawImageInfo info = reader.info();
  check_channels(path, info);
  const int width = info.width, height = info.height;
  const bool is_data = encoding == ColourEncoding::kData;
  const TransferFunction transfer = transfer_function(info, encoding);
  const SampleConverter converter =
      is_data ? data_converter(info.base_type) : linear_converter(info.base_type, transfer);
  ColourRows albedo{make_plane_store(width, height, spill), info.channel_count,
                    info.format + ", " + (is_data ? "data" : transfer.name)};
  std::atomic<std::int64_t> clamped_count{0};
  std::mutex largest_mutex;
  const auto add_rows = [&](const RawBand& band, int row_begin, int row_end) {
    const auto columns = static_cast<std::size_t>(width);
    std::vector<float> values(info.row_values());
    std::array<std::vector<float>, 3> planes;
    for (std::vector<float>& plane : planes) plane.resize(static_cast<std::size_t>(row_end - row_begin) * columns);
    for (int row = row_begin; row < row_end; ++row) {
      converter.convert(band.samples + static_cast<std::size_t>(row) * info.row_bytes, values.size(), values.data());
      const std::size_t first = static_cast<std::size_t>(row - row_begin) * columns;
      clamped_count += separate_row(values, {&planes[0][first], &planes[1][first], &planes[2][first]},
                                    static_cast<std::size_t>(info.channel_count));
    }
    float largest = 0.0f;
    for (const std::vector<float>& plane : planes)
      for (const float value : plane) largest = std::max(largest, value);
    {
      const std::lock_guard lock(largest_mutex);
      albedo.largest = std::max(albedo.largest, largest);
    }
    albedo.planes.write_rows(band.first_row + row_begin, row_end - row_begin,
                             {planes[0].data(), planes[1].data(), planes[2].data()});
  };
  const auto add_band = [&](const RawBand& band) {
    for_each_row_band(band.row_count, kRowsPerBand, threads,
                      [&](int, int row_begin, int row_end) { add_rows(band, row_begin, row_end); });
  };
  reader.read(add_band, progress);
  albedo.clamped_count = clamped_count;
  albedo.notes = info.notes;
  if (is_data && clamped_count > 0)
    throw Error(ErrorCode::kInput, fmt::format("{}: found {} texels that are not finite, expected finite numbers", path,
                                               albedo.clamped_count));
  return albedo;
}

ColourRows read_albedo(const std::string& path, int width, int height, const SpillPolicy& spill, int threads) {
  ImageReader reader(path, reading_settings(spill, threads));
  check_albedo_size(path, reader.info(), width, height);
  return read_rows(reader, path, ColourEncoding::kAuto, spill, threads, nullptr);
}

}  // namespace

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

ColourRows read_colour_rows(const std::string& path, ColourEncoding encoding, const SpillPolicy& spill, int threads,
                            Progress* progress) {
  ImageReader reader(path, reading_settings(spill, threads));
  return read_rows(reader, path, encoding, spill, threads, progress);
}

ColourRows read_albedo_rows(const std::string& path, int width, int height, const SpillPolicy& spill, int threads) {
  return read_albedo(path, width, height, spill, threads);
}

ColourMap read_albedo_map(const std::string& path, int width, int height, int threads) {
  ColourRows rows = read_albedo(path, width, height, {}, threads);
  std::array<std::vector<float>, 3> planes = rows.planes.take_planes();
  ColourMap map;
  map.width = width;
  map.height = height;
  map.format = std::move(rows.format);
  map.clamped_count = rows.clamped_count;
  map.notes = std::move(rows.notes);
  map.r = std::move(planes[0]);
  map.g = std::move(planes[1]);
  map.b = std::move(planes[2]);
  return map;
}

}  // namespace multum
