// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/texture_encoding.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "host/delivery/export/texture_file.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kRowsAtOnce = 64;
constexpr int kZstdLevel = 12;  // Basis Universal's own is 6; those above 12 take several times as long for a percent

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
  const std::string path = levels.path() + ".ktx2";
  const bool is_uastc = format == GltfTextureFormat::kUastc;
  const LeveledTexture texture{is_uastc ? TexelFormat::kUastc : TexelFormat::kRgba8, levels.width(), levels.height(),
                               levels.level_count()};
  std::vector<std::vector<std::uint8_t>> blocks;
  if (is_uastc) blocks = encode_uastc(levels, uastc, progress);
  Ktx2Choice choice;
  if (is_uastc) choice.zstd_level = kZstdLevel;
  const std::unique_ptr<TextureFile> file = make_ktx2_file(path, texture, choice);
  for (int level = 0; level < levels.level_count(); ++level) {
    const int rows = block_rows(texture, level);
    if (!is_uastc) blocks.push_back(levels.read_rows(level, 0, rows));
    file->write_rows(level, rows, blocks[size_of(level)].data());
    blocks[size_of(level)] = {};
  }
  file->finish();
  return {path, "image/ktx2", std::filesystem::file_size(path)};
}

}  // namespace multum
