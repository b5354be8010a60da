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
// Basis Universal uses level 6. Levels above 12 take several times as long and save only one percent.
constexpr int kZstdLevel = 12;

FallbackImage write_png(const LevelFile& levels) {
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
  return {path, std::filesystem::file_size(path)};
}

using LevelBlocks = std::vector<std::vector<std::uint8_t>>;

// `blocks` holds the blocks of all levels. If it is empty, stores the texels themselves.
EncodedTexture write_ktx2(const LevelFile& levels, GltfTextureFormat format, int zstd_level, LevelBlocks blocks) {
  const std::string path = levels.path() + ".ktx2";
  const TexelFormat texels = format == GltfTextureFormat::kUastc ? TexelFormat::kUastc : TexelFormat::kRgba8;
  const LeveledTexture texture{texels, levels.width(), levels.height(), levels.level_count()};
  Ktx2Choice choice;
  choice.zstd_level = zstd_level;
  const std::unique_ptr<TextureFile> file = make_ktx2_file(path, texture, choice);
  blocks.resize(size_of(levels.level_count()));
  for (int level = 0; level < levels.level_count(); ++level) {
    std::vector<std::uint8_t>& of_level = blocks[size_of(level)];
    const int rows = block_rows(texture, level);
    if (of_level.empty()) of_level = levels.read_rows(level, 0, rows);
    file->write_rows(level, rows, of_level.data());
    of_level = {};
  }
  file->finish();
  return {path, "image/ktx2", std::filesystem::file_size(path), choice_name(kGltfTextureFormats, format)};
}

struct UastcTrial {
  LevelBlocks blocks;
  double error = 0.0;
};

UastcTrial encode_and_measure(const LevelFile& levels, const UastcSettings& uastc, const TextureEncoding& how,
                              Progress* progress) {
  const std::filesystem::path path(levels.path());
  const LevelFile decoded(path.parent_path().string(), path.filename().string() + ".decoded", levels.width(),
                          levels.height());
  UastcTrial made{encode_uastc(levels, uastc, progress, &decoded)};
  made.error = how.measure(decoded).error;
  std::error_code ignored;
  std::filesystem::remove(decoded.path(), ignored);
  return made;
}

// Choosing blocks by angle reduces angle errors by 3 to 20 %, but encoding takes two to three times as long. Blocks are
// therefore chosen by angle only if this can change the format, or if the user requested UASTC.
constexpr double kWorthChoosing = 2.0 * kStorageErrorMax;

UastcTrial try_uastc(const LevelFile& levels, const TextureEncoding& how, Progress* progress) {
  UastcSettings plain = how.uastc;
  plain.has_normals = false;
  if (how.format == GltfTextureFormat::kAuto && how.uastc.has_normals) {
    UastcTrial trial = encode_and_measure(levels, plain, how, progress);
    if (trial.error < kStorageErrorMax || trial.error >= kWorthChoosing) return trial;
  }
  return encode_and_measure(levels, how.uastc, how, progress);
}

}  // namespace

EncodedTexture encode_texture(const LevelFile& levels, const TextureEncoding& how, Progress* progress) {
  if (how.format == GltfTextureFormat::kPng) {
    const FallbackImage image = write_png(levels);
    return {image.file, "image/png", image.byte_count, "png"};
  }
  const bool is_auto = how.format == GltfTextureFormat::kAuto;
  UastcTrial trial;
  if (is_auto || how.format == GltfTextureFormat::kUastc) trial = try_uastc(levels, how, progress);
  const bool is_refused = is_auto && trial.error >= kStorageErrorMax;
  if (is_refused) trial.blocks.clear();
  const bool is_uastc = !trial.blocks.empty();
  EncodedTexture made = write_ktx2(levels, is_uastc ? GltfTextureFormat::kUastc : GltfTextureFormat::kRgba8,
                                   how.format == GltfTextureFormat::kRgba8 ? 0 : kZstdLevel, std::move(trial.blocks));
  (is_refused ? made.refused_error : made.storage_error) = trial.error;
  if (how.has_fallback || is_refused) made.fallback = how.is_original ? FallbackImage{} : write_png(levels);
  return made;
}

}  // namespace multum
