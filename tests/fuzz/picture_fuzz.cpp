// SPDX-License-Identifier: Apache-2.0
// Fuzzes the readers of pictures that use a small library each: libpng, libjpeg, and this project's reader of KTX2 with
// Zstandard and UASTC. The first byte of an input is odd if the checksums of PNG chunks are repaired, because libpng
// reads no further than a wrong checksum.
#include <zlib.h>
#include <zstd.h>

// libjpeg's header needs these.
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>

#include "host/formats/decoder/library_image_file.h"
#include "host/formats/image/files/png_writer.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

constexpr std::string_view kPngMagic = "\x89PNG\r\n\x1a\n";
constexpr std::int64_t kTexelsMost = 1 << 16;
constexpr int kBandRows = 5;

std::string bytes_of(std::uint64_t value, std::size_t count, bool is_big_endian = false) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i));
  if (is_big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string with_checksums(std::string png) {
  constexpr std::size_t kHead = 8, kChecksum = 4;  // length and type; the data follows, and then the checksum
  for (std::size_t at = kPngMagic.size(); png.size() >= at + kHead + kChecksum;) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<unsigned char>(png[at + i]);
    if (length > png.size() - at - kHead - kChecksum) break;
    const auto* data = reinterpret_cast<const Bytef*>(png.data() + at + 4);
    png.replace(at + kHead + length, kChecksum,
                bytes_of(crc32(0, data, static_cast<uInt>(length + 4)), kChecksum, true));
    at += kHead + length + kChecksum;
  }
  return png;
}

std::string jpeg(int components) {
  constexpr int kWidth = 20, kHeight = 12;
  jpeg_compress_struct state{};
  jpeg_error_mgr errors{};
  state.err = jpeg_std_error(&errors);
  jpeg_create_compress(&state);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&state, &memory, &size);
  state.image_width = kWidth;
  state.image_height = kHeight;
  state.input_components = components;
  state.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&state);
  if (components == 1) jpeg_simple_progression(&state);
  jpeg_start_compress(&state, TRUE);
  std::vector<JSAMPLE> row(static_cast<std::size_t>(kWidth * components));
  for (int y = 0; y < kHeight; ++y) {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<JSAMPLE>(11 * i + 17 * static_cast<unsigned>(y));
    JSAMPROW rows[] = {row.data()};
    jpeg_write_scanlines(&state, rows, 1);
  }
  jpeg_finish_compress(&state);
  std::string made(reinterpret_cast<const char*>(memory), size);
  jpeg_destroy_compress(&state);
  free(memory);
  return made;
}

// A KTX2 file with one level. `model` is 1 for plain values, or 166 for UASTC (Khronos Data Format).
std::string ktx2(unsigned format, unsigned width, unsigned height, unsigned model, const std::string& level,
                 bool is_packed) {
  constexpr unsigned kDescriptorAt = 104, kLevelAt = 144;
  std::string stored = level;
  if (is_packed) {
    stored.resize(ZSTD_compressBound(level.size()));
    stored.resize(ZSTD_compress(stored.data(), stored.size(), level.data(), level.size(), 3));
  }
  std::string file("\xabKTX 20\xbb\r\n\x1a\n", 12);
  for (const unsigned word :
       {format, 1u, width, height, 0u, 0u, 1u, 1u, is_packed ? 2u : 0u, kDescriptorAt, 40u, 0u, 0u})
    file += bytes_of(word, 4);
  for (const std::size_t word : {std::size_t{0}, std::size_t{0}, std::size_t{kLevelAt}, stored.size(), level.size()})
    file += bytes_of(word, 8);
  for (const unsigned word : {40u, 0u, 2u + (36u << 16), model + (1u << 8) + (1u << 16)}) file += bytes_of(word, 4);
  file.resize(kLevelAt, '\0');
  return file + stored;
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  std::vector<std::string> seeds;
  const std::string path = scratch_folder() + "/seed.png";
  const auto add = [&](const std::string& bytes) { seeds.push_back("\1" + bytes); };
  for (const int channels : {1, 3, 4}) {
    Png8Image image{9, 7, channels, {}};
    for (int i = 0; i < 9 * 7 * channels; ++i) image.interleaved.push_back(static_cast<std::uint8_t>(37 * i));
    write_png8(path, image);
    add(file_bytes(path));
  }
  std::vector<std::uint16_t> wide;
  for (unsigned i = 0; i < 6 * 5 * 3; ++i) wide.push_back(static_cast<std::uint16_t>(9173 * i));
  write_png16(path, 6, 5, wide, "linear");
  add(file_bytes(path));
  add(jpeg(3));
  add(jpeg(1));
  std::string texels;
  for (int i = 0; i < 8 * 4 * 4; ++i) texels += static_cast<char>(29 * i);
  add(ktx2(37, 8, 4, 1, texels, false));
  add(ktx2(37, 8, 4, 1, texels, true));
  add(ktx2(0, 8, 4, 166, texels.substr(0, 32), false));
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 2);
  std::string bytes(input.bytes);
  if (input.kind == 1 && bytes.starts_with(kPngMagic)) bytes = with_checksums(std::move(bytes));
  const std::string path = fuzz::input_file("input", bytes);
  fuzz::may_refuse([&] {
    ImageFileSettings settings;
    settings.texel_count_max = kTexelsMost;
    const auto file = open_small_library_image(path, settings);
    if (file == nullptr) throw Error(ErrorCode::kInput, "not a format of this fuzzer");
    check_described(path, file->description(), settings.texel_count_max);
    const ImagePart& part = file->part();
    for (int y = part.y; y < part.y + part.height; y += kBandRows) {
      const PixelBlock block{
          0, y, std::min(y + kBandRows, part.y + part.height), 0, part.channel_count(), part.base_type};
      file->reserve(block_bytes(part, block));
      if (const std::string why = file->read(block, 0, {}); !why.empty()) throw Error(ErrorCode::kInput, why);
    }
  });
  return 0;
}
