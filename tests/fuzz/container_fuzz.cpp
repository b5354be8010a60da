// SPDX-License-Identifier: Apache-2.0
// Fuzzes the first check of image files (host/formats/image/files/image_container.h), and the reader of Radiance files,
// which this project decodes with its own code.
#include <cmath>

#include "host/formats/decoder/file_ranges.h"
#include "host/formats/image/files/environment_file.h"
#include "host/formats/image/files/image_container.h"
#include "host/formats/image/files/image_file.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}
std::string little_endian(std::uint32_t value) {
  const std::string big = big_endian(value);
  return {big.rbegin(), big.rend()};
}
std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + "crc!";
}
std::string exr_attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + little_endian(static_cast<std::uint32_t>(value.size())) + value;
}

std::string exr(std::uint32_t version, const std::string& attributes) {
  return "\x76\x2f\x31\x01" + little_endian(version) + attributes + '\0' + std::string(64, '\1');
}

}  // namespace

// These containers do not hold a picture, and no library decodes them.
std::vector<std::string> fuzz::seeds() {
  using namespace std::string_literals;
  const std::string png = "\x89PNG\r\n\x1a\n"s + chunk("IHDR", big_endian(8) + big_endian(4) + "\x8\2\0\0\0"s) +
                          chunk("tEXt", "Title\0much"s) + chunk("IDAT", std::string(30, 'x')) + chunk("IEND", "");
  const std::string jpeg =
      "\xFF\xD8\xFF\xE0\0\x4JF\xFF\xE1\0\x6"s + "Exif\xFF\xC0\0\xB\x8\0\x8\0\x8\1\1\x11\0\xFF\xDA\0\2data\xFF\xD9"s;
  const std::string window = little_endian(0) + little_endian(0) + little_endian(7) + little_endian(3);
  const std::string tiles = exr_attribute("tiles", "tiledesc", little_endian(4) + little_endian(4) + '\0');
  const std::string data_window = exr_attribute("dataWindow", "box2i", window);
  std::vector<std::string> seeds = {png,
                                    jpeg,
                                    exr(2, data_window),
                                    exr(0x202, data_window + tiles),
                                    exr(0x1002, data_window + '\0' + data_window),
                                    "II*\0\x8\0\0\0"s};
  const auto webp = [&](const std::string& picture) {
    return "RIFF" + little_endian(static_cast<std::uint32_t>(picture.size() + 4)) + "WEBP" + picture;
  };
  seeds.push_back(webp("VP8X" + little_endian(10) + std::string(4, '\0') + "\7\0\0\3\0\0"s));
  seeds.push_back(webp("VP8L" + little_endian(10) + "\x2f\7\xc0\0\0\0\0\0\0\0"s));
  seeds.push_back(webp("VP8 " + little_endian(10) + "\0\0\0\x9d\1\x2a\x8\0\4\0"s));
  std::string packed = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 4 +X 8\n";
  for (int y = 0; y < 4; ++y) {
    packed += "\2\2\0\x8"s;
    for (int plane = 0; plane < 4; ++plane) packed += "\x84\x40\4"s + "abcd";
  }
  seeds.push_back(packed);
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const std::string path = fuzz::input_file("input", {reinterpret_cast<const char*>(data), size});
  fuzz::may_refuse([&] {
    const ImageContainer container = inspect_image_container(path, std::int64_t{1} << 30);
    MULTUM_CHECK(container.width >= 0 && container.height >= 0 && container.file_size >= 0);
    // The libraries get only these parts of the file.
    FileRanges ranges(path, container.ranges);
    std::string bytes(ranges.size(), '\0');
    MULTUM_CHECK(bytes.size() <= size && ranges.read(bytes.data(), bytes.size(), 0) == bytes.size());
  });
  set_image_opener([](const std::string& name, const ImageFileSettings&) -> std::unique_ptr<ImageFile> {
    throw Error(ErrorCode::kInput, name + ": is no Radiance file");
  });
  fuzz::may_refuse([&] {
    for (const float red : read_environment_map(path).r) MULTUM_CHECK(std::isfinite(red) && red >= 0.0f);
  });
  return 0;
}
