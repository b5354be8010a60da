// SPDX-License-Identifier: Apache-2.0
#include "host/gltf/texture_encoding.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "host/asset/baked_file.h"
#include "host/base/size_of.h"
#include "host/gltf/ktx2_levels.h"
#include "host/image/files/png_writer.h"

namespace multum {
namespace {

constexpr int kRowsAtOnce = 64;

EncodedTexture encode_png(const LevelFile& levels) {
  const std::string path = levels.path() + ".png";
  Png8Writer writer(path, levels.width(), levels.height());
  for (int row = 0; row < levels.height(); row += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, levels.height() - row);
    const std::vector<std::uint8_t> rgba = levels.read_rows(0, row, count);
    std::vector<std::uint8_t> rgb;
    rgb.reserve(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size(); i += 4) rgb.insert(rgb.end(), &rgba[i], &rgba[i] + 3);
    writer.write_rows(count, rgb.data());
  }
  writer.finish();
  return {path, "image/png", std::filesystem::file_size(path)};
}

}  // namespace

EncodedTexture encode_texture(const LevelFile& levels, GltfTextureFormat format, const UastcSettings& uastc,
                              Progress* progress) {
  if (format == GltfTextureFormat::kPng) return encode_png(levels);
  EncodedTexture made{levels.path() + ".ktx2", "image/ktx2", 0};
  Ktx2LevelsSettings settings{Ktx2Texels::kRgba8, levels.width(), levels.height(), levels.level_count(), false};
  if (format == GltfTextureFormat::kRgba8) {
    made.byte_count = write_ktx2_levels(made.file, settings, [&](int level) {
      return levels.read_rows(level, 0, mip_level_size(levels.height(), level));
    });
    return made;
  }
  settings.texels = Ktx2Texels::kUastc;
  settings.is_supercompressed = true;
  std::vector<std::vector<std::uint8_t>> blocks = encode_uastc(levels, uastc, progress);
  made.byte_count =
      write_ktx2_levels(made.file, settings, [&](int level) { return std::move(blocks[size_of(level)]); });
  return made;
}

}  // namespace multum
