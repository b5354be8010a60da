// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/exports/exported_levels.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "host/delivery/export/block_decoding.h"
#include "host/foundation/base/half_bits.h"

namespace multum::testing {

Picture read_picture(const std::string& path) {
  Picture picture;
  OIIO::ImageSpec as_stored;  // otherwise OpenImageIO multiplies colours by alpha
  as_stored.attribute("oiio:UnassociatedAlpha", 1);
  const auto file = OIIO::ImageInput::open(path, &as_stored);
  EXPECT_NE(file, nullptr) << path;
  if (!file) return picture;
  picture.width = file->spec().width;
  picture.height = file->spec().height;
  picture.channels = file->spec().nchannels;
  picture.is_half = file->spec().format == OIIO::TypeDesc::HALF;
  picture.values.resize(static_cast<std::size_t>(picture.width * picture.height * picture.channels));
  EXPECT_TRUE(file->read_image(0, 0, 0, picture.channels, OIIO::TypeDesc::FLOAT, picture.values.data()));
  return picture;
}

std::string level_of(const std::string& bytes, TexelFormat format, int width, int height, int level) {
  const auto number_at = [&](std::size_t at, std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return static_cast<std::size_t>(value);
  };
  if (bytes.rfind("DDS ", 0) != 0) {
    const std::size_t entry = 80 + 24 * static_cast<std::size_t>(level);
    return bytes.substr(number_at(entry, 8), number_at(entry + 8, 8));
  }
  const LeveledTexture texture{format, width, height, 16};
  std::uint64_t at = 148;
  for (int l = 0; l < level; ++l) at += level_bytes(texture, l);
  return bytes.substr(at, level_bytes(texture, level));
}

std::vector<float> decoded_level(const std::string& bytes, TexelFormat format, int width, int height) {
  const TexelFormatInfo& info = info_of(format);
  const auto* at = reinterpret_cast<const std::uint8_t*>(bytes.data());
  std::vector<float> texels(static_cast<std::size_t>(4 * width * height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int side = info.block_side, columns = (width + side - 1) / side;
      const auto* block = at + (y / side * columns + x / side) * info.block_bytes;
      float* texel = texels.data() + 4 * (y * width + x);
      if (side == 4) {
        const glm::vec4 value = decode_block(format, block)[static_cast<std::size_t>(y % 4 * 4 + x % 4)];
        for (int c = 0; c < 4; ++c) texel[c] = value[c];
        continue;
      }
      for (int c = 0; c < 4; ++c) {
        if (c >= info.channels) texel[c] = c == 3 ? 1.0f : 0.0f;
        else if (info.is_float)
          texel[c] = half_to_float(static_cast<std::uint16_t>(block[2 * c] | block[2 * c + 1] << 8));
        else texel[c] = static_cast<float>(block[c]) / 255.0f;
      }
    }
  return texels;
}

}  // namespace multum::testing
