// SPDX-License-Identifier: Apache-2.0
// Simulates a corrupted decoder. The first byte of the input chooses the reader. The other bytes are the decoder's
// answer to "open" and its pixels. They pass through all code that reads pictures: sizes, bands, encodings, heights,
// colours, weights, and Cryptomatte.
#include <algorithm>
#include <cstring>
#include <numeric>

#include "host/formats/image/files/decoding_messages.h"
#include "host/formats/image/files/environment_file.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/formats/image/files/number_type.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/object_index.h"
#include "host/formats/image/small_picture.h"
#include "host/foundation/sandbox/byte_message.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

const AskedFile kAsked = {"fuzz.png", "OpenImageIO", 1u << 30};

class MadFile : public ImageFile {
 public:
  MadFile(std::string_view answer, std::string_view pixels) : pixels_(pixels) {
    description_ = parse_answer(kAsked, answer, parse_open_answer);
    // Allows only small pictures, because large ones take time and are tested elsewhere.
    for (const ImagePart& part : description_.parts)
      if (part.width > 512 || part.height > 512 || part.channel_count() > 80)
        check_described(kAsked.path, description_, 1);
  }
  std::byte* reserve(std::size_t byte_count) override {
    if (byte_count > std::size_t{64} << 20) throw Error(ErrorCode::kEnvironment, "more than a fuzzer needs");
    memory_.assign(byte_count, std::byte{0});
    return memory_.data();
  }
  std::string read(const PixelBlock& block, std::size_t offset, const std::function<void()>&) override {
    const std::size_t size = block_bytes(part(block.part), block);
    MULTUM_CHECK(block.y_begin < block.y_end && block.channel_begin < block.channel_end);
    MULTUM_CHECK(block.y_begin >= part(block.part).y && block.channel_end <= part(block.part).channel_count());
    MULTUM_CHECK(offset <= memory_.size() && size <= memory_.size() - offset);
    if (pixels_.empty()) return "no pixels";
    for (std::size_t i = 0; i < size; ++i)
      memory_[offset + i] =
          static_cast<std::byte>(pixels_[(i + static_cast<std::size_t>(block.y_begin - part().y)) % pixels_.size()]);
    return "";
  }

 private:
  std::string pixels_;
  std::vector<std::byte> memory_;
};

// The input is [size of the answer, 2 bytes], the answer, and the pixels.
constexpr std::size_t kHeadSize = 2;

std::string input_of(const ImageDescription& description, unsigned reader, const std::string& pixels) {
  const std::string answer = open_answer(description);
  const auto size = static_cast<std::uint16_t>(answer.size());
  std::string input(1, static_cast<char>(reader));
  input.append(reinterpret_cast<const char*>(&size), kHeadSize);
  return input + answer + pixels;
}

ImageDescription picture(int width, int height, int type, std::vector<std::string> channels) {
  ImagePart part;
  part.width = part.full_width = width;
  part.height = part.full_height = height;
  part.base_type = type;
  part.channel_names = std::move(channels);
  return {"openexr", 4096, {part}};
}

void read_as(unsigned reader) {
  const std::string& path = kAsked.path;
  NormalMapSettings settings;
  settings.texel_count_max = 1 << 18;
  settings.repair_share_max = 1.0f;
  switch (reader) {
    case 0: read_normal_map(path, settings, 1, nullptr); break;
    case 1:
      settings.bump_format = BumpFormat::kHeight;
      settings.fix_nan = FixNan::kBlack;
      read_normal_map(path, settings, 1, nullptr);
      break;
    case 2:
      settings.bump_format = BumpFormat::kNormal;
      settings.two_channel = true;
      read_normal_map(path, settings, 1, nullptr);
      break;
    case 3: read_albedo_map(path, 8, 8, 1); break;
    case 4: read_colour_rows(path, ColourEncoding::kData, {}, 1, nullptr); break;
    case 5: read_weight_map(path, 8, 8, {}, 1); break;
    case 6: {
      PlaneStore normals(8, 8);
      shorten_by_roughness(normals, {path, "G"}, {}, 1);
      break;
    }
    case 7: read_exr_channels(path, {"R"}); break;
    case 8:
      for (const std::string& name : find_cryptomatte_names(path, "CryptoObject", {"other"}).manifest)
        read_cryptomatte_coverage(path, "CryptoObject", {name, "other"});
      break;
    case 9: read_object_index_coverage(path, 8, 8, {1, 2, 300}); break;
    case 10: read_environment_map(path); break;
    default: read_small_picture(path, 16);
  }
}
constexpr unsigned kReaderCount = 12;

}  // namespace

std::vector<std::string> fuzz::seeds() {
  std::string pixels(768, '\0');
  std::iota(pixels.begin(), pixels.end(), static_cast<char>(100));
  const std::vector<std::string> rgb = {"R", "G", "B"};
  std::vector<std::string> seeds;
  for (unsigned reader = 0; reader < 7; ++reader)
    for (const auto type : {number_type::kUint8, number_type::kUint16, number_type::kHalf})
      seeds.push_back(input_of(picture(8, 8, type, rgb), reader, pixels));
  seeds.push_back(input_of(picture(8, 8, number_type::kFloat, {"Y"}), 1, pixels));
  seeds.push_back(input_of(picture(8, 8, number_type::kFloat, rgb), 7, pixels));
  seeds.push_back(input_of(picture(8, 8, number_type::kUint8, {"Y"}), 9, pixels));
  seeds.push_back(input_of(picture(16, 8, number_type::kHalf, rgb), 10, pixels));
  seeds.push_back(input_of(picture(40, 30, number_type::kUint8, rgb), 11, pixels));
  ImageDescription matte = picture(8, 8, number_type::kFloat, {"CryptoObject00.r", "CryptoObject00.g"});
  matte.parts[0].texts = {{"cryptomatte/1/name", "CryptoObject"},
                          {"cryptomatte/1/hash", "MurmurHash3_32"},
                          {"cryptomatte/1/conversion", "uint32_to_float32"},
                          {"cryptomatte/1/manifest", R"({"thing":"3f800000"})"}};
  seeds.push_back(input_of(matte, 8, pixels));
  ImageDescription tiles = picture(32, 32, number_type::kHalf, rgb);
  tiles.parts[0].tile_width = tiles.parts[0].tile_height = 16;
  tiles.parts[0].channel_types = {number_type::kHalf, number_type::kFloat, number_type::kHalf};
  seeds.push_back(input_of(tiles, 0, pixels));
  ImageDescription webp = picture(8, 8, number_type::kUint8, {"R", "G", "B", "A"});
  webp.format = "webp";
  webp.parts[0].alpha_channel = 3;
  seeds.push_back(input_of(webp, 0, std::string(8, '\xff')));
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto [reader, bytes] = fuzz::split(data, size, kReaderCount);
  std::uint16_t answer_size = 0;
  if (bytes.size() < kHeadSize) return 0;
  std::memcpy(&answer_size, bytes.data(), kHeadSize);
  const std::string_view rest = bytes.substr(kHeadSize), answer = rest.substr(0, answer_size);
  set_image_opener([&](const std::string&, const ImageFileSettings&) {
    return std::make_unique<MadFile>(answer, rest.substr(answer.size()));
  });
  fuzz::may_refuse([&, which = reader] { read_as(which); });
  fuzz::may_refuse([&] { parse_answer(kAsked, answer, parse_read_answer); });
  return 0;
}
