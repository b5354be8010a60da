// SPDX-License-Identifier: Apache-2.0
// Reads Radiance's format (Ward 1991, "Real Pixels"; Radiance's filefmts). Such a file consists of "#?" and lines of
// text up to an empty line, then "-Y height +X width", then rows of RGBE texels: mantissas of 8 bits with one exponent,
// (R, G, B) 2^(E - 136). A row of 8 to 32767 texels can be run-length coded. Such a row has the bytes 2, 2 and the
// width (two bytes), then one plane per channel. A plane is a list of runs. A run is a byte 128 + n and one value that
// is repeated n times, or a byte n <= 128 and n values. Other orders of rows and columns, and XYZE, are rejected.
#include "host/formats/image/files/environment_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "host/formats/image/image_reader.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/leading_number.h"

namespace multum {
namespace {

void check_size(const std::string& path, int width, int height) {
  if (height < 4 || height > kEnvironmentWidthLimit / 2 || width != 2 * height)
    refuse_file(path, fmt::format("found an image of {} x {}, expected a latitude-longitude environment that is twice "
                                  "as wide as high, from 8 x 4 to {} x {}",
                                  width, height, kEnvironmentWidthLimit, kEnvironmentWidthLimit / 2));
}

bool is_radiance(const std::string& path) { return first_bytes(path, 2) == "#?"; }

class RadianceReader {
 public:
  explicit RadianceReader(const std::string& path) : path_(path) {
    constexpr std::uintmax_t kBytesMax = std::uintmax_t{1} << 30;
    std::error_code error;
    if (std::filesystem::file_size(path, error) > kBytesMax && !error)
      refuse_file(path, "is larger than 1 GiB, which is the limit for an environment");
    RegularFileStream in(path);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
  }

  void check() { read_header(); }

  ColourMap read() {
    const double exposure = read_header();
    ColourMap map;
    map.width = width_;
    map.height = height_;
    map.format = "hdr rgbe, 3 channels, linear";
    std::vector<unsigned char> row(4 * static_cast<std::size_t>(width_));
    for (int y = 0; y < height_; ++y) {
      read_row(row);
      for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
        const unsigned char* texel = &row[4 * x];
        const double scale = texel[3] == 0 ? 0.0 : std::ldexp(1.0, texel[3] - 136) / exposure;
        map.r.push_back(static_cast<float>(texel[0] * scale));
        map.g.push_back(static_cast<float>(texel[1] * scale));
        map.b.push_back(static_cast<float>(texel[2] * scale));
      }
    }
    return map;
  }

 private:
  std::string line() {
    const std::size_t end = bytes_.find('\n', position_);
    if (end == std::string::npos || end - position_ > 4096)
      refuse_file(path_, "damaged Radiance file: its header does not end");
    const std::string text = bytes_.substr(position_, end - position_);
    position_ = end + 1;
    return text;
  }

  /// Returns the product of the values in the EXPOSURE lines.
  double read_header() {
    double exposure = 1.0;
    for (std::string text = line(); !text.empty(); text = line()) {
      constexpr std::string_view kExposure = "EXPOSURE=";
      const double value =
          text.starts_with(kExposure) ? leading_number(text.substr(kExposure.size())).value_or(0.0) : 0.0;
      if (value > 0.0 && std::isfinite(value)) exposure *= value;
      if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe")
        refuse_file(path_, "found " + text + ", expected FORMAT=32-bit_rle_rgbe");
    }
    const std::string size = line();
    int used = 0;
    if (std::sscanf(size.c_str(), "-Y %d +X %d%n", &height_, &width_, &used) != 2 ||
        static_cast<std::size_t>(used) != size.size())
      refuse_file(path_, "found the size '" + size.substr(0, 40) + "', expected -Y height +X width");
    check_size(path_, width_, height_);
    return exposure;
  }

  const unsigned char* take(std::size_t count) {
    if (count > bytes_.size() - position_)
      refuse_file(path_, fmt::format("the file is cut short: it ends at byte {}", bytes_.size()));
    const auto* data = reinterpret_cast<const unsigned char*>(bytes_.data()) + position_;
    position_ += count;
    return data;
  }

  void read_row(std::vector<unsigned char>& row) {
    const auto width = static_cast<std::size_t>(width_);
    const unsigned char* head = take(4);
    const bool is_packed = head[0] == 2 && head[1] == 2 && head[2] < 128;
    if (!is_packed) {
      position_ -= 4;
      const unsigned char* data = take(4 * width);
      std::copy(data, data + 4 * width, row.begin());
      return;
    }
    if (static_cast<std::size_t>(head[2]) * 256 + head[3] != width)
      refuse_file(path_, "damaged Radiance file: a row has the wrong width");
    for (std::size_t plane = 0; plane < 4; ++plane)
      for (std::size_t x = 0; x < width;) {
        const std::size_t code = *take(1);
        const bool is_run = code > 128;
        const std::size_t count = is_run ? code - 128 : code;
        if (count == 0 || count > width - x) refuse_file(path_, "damaged Radiance file: a run extends beyond its row");
        const unsigned char* data = take(is_run ? 1 : count);
        for (std::size_t i = 0; i < count; ++i) row[4 * (x++) + plane] = data[is_run ? 0 : i];
      }
  }

  std::string path_, bytes_;
  std::size_t position_ = 0;
  int width_ = 0, height_ = 0;
};

RawImageInfo checked_info(const std::string& path) {
  const RawImageInfo info = ImageReader(path, {}).info();
  check_size(path, info.width, info.height);
  return info;
}

}  // namespace

void check_environment_map(const std::string& path) {
  if (is_radiance(path)) RadianceReader(path).check();
  else checked_info(path);
}

ColourMap read_environment_map(const std::string& path) {
  if (is_radiance(path)) return RadianceReader(path).read();
  const RawImageInfo info = checked_info(path);
  return read_albedo_map(path, info.width, info.height, 1);
}

}  // namespace multum
