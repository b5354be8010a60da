// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/material_textures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "host/delivery/export/block_decoding.h"
#include "host/delivery/export/texture_file.h"
#include "host/delivery/export/uastc/level_file.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/exr/picture_file.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

bool is_alone(TextureRole role) {
  return role == TextureRole::kRoughness || role == TextureRole::kSmoothness || role == TextureRole::kOcclusion ||
         role == TextureRole::kMetalness;
}

int image_channels(TextureRole role) { return role == TextureRole::kMask ? 4 : 3; }

// Returns the texel format of KTX2 and DDS files.
TexelFormat texel_format(TextureRole role, MaterialTexels texels) {
  const bool has_blocks = texels == MaterialTexels::kBlocks;
  if (is_half(texels)) return TexelFormat::kRgba16f;
  if (texels == MaterialTexels::kUastc)
    return role == TextureRole::kMask ? TexelFormat::kUastcAlpha : TexelFormat::kUastc;
  if (is_alone(role)) return has_blocks ? TexelFormat::kBc4 : TexelFormat::kR8;
  if (role == TextureRole::kNormal && has_blocks) return TexelFormat::kBc5;
  if (role == TextureRole::kNormal && texels == MaterialTexels::kRg8) return TexelFormat::kRg8;
  return has_blocks ? TexelFormat::kBc7 : TexelFormat::kRgba8;
}

// Returns the swizzle for channels that are not stored. With this swizzle, readers see normals that point up instead of
// down, and roughness in every colour channel.
std::string swizzle_of(TexelFormat format) {
  const int channels = info_of(format).channels;
  return channels == 1 ? "rrr1" : channels == 2 ? "rg11" : "";
}

// Returns y of a normal or direction with the sign of the file's green axis. The same call converts it back.
float turned_y(const MaterialFolderSettings& settings, float y) { return settings.green_is_down ? -y : y; }

glm::vec4 texel_of(TextureRole role, const MaterialFolderSettings& settings, const MaterialRows& rows, std::size_t i) {
  const auto component = [&](float v) { return is_half(settings.texels) ? v : 0.5f + 0.5f * v; };
  const auto occlusion = [&] { return rows.occlusion.empty() ? 1.0f : rows.occlusion[i]; };
  const auto metalness = [&] { return rows.metalness.empty() ? 0.0f : rows.metalness[i]; };
  switch (role) {
    case TextureRole::kNormal: {
      const glm::vec3& n = rows.normals[i];
      return {component(n.x), component(turned_y(settings, n.y)), component(n.z), 1.0f};
    }
    case TextureRole::kOrm: return {occlusion(), rows.roughness[i], metalness(), 1.0f};
    case TextureRole::kMask: return {metalness(), occlusion(), 1.0f, 1.0f - rows.roughness[i]};
    case TextureRole::kRoughness: return {glm::vec3(rows.roughness[i]), 1.0f};
    case TextureRole::kSmoothness: return {glm::vec3(1.0f - rows.roughness[i]), 1.0f};
    case TextureRole::kOcclusion: return {glm::vec3(occlusion()), 1.0f};
    case TextureRole::kMetalness: return {glm::vec3(metalness()), 1.0f};
    case TextureRole::kAnisotropy: {
      const glm::vec3& a = rows.anisotropy[i];
      return {component(a.x), component(turned_y(settings, a.y)), a.z, 1.0f};
    }
  }
  MULTUM_CHECK(false);
}

void set_texel(TextureRole role, const MaterialFolderSettings& settings, const glm::vec4& texel, MaterialRows& rows,
               std::size_t i) {
  const auto component = [](float share) { return 2.0f * share - 1.0f; };
  const auto set_maps = [&](float occlusion, float metalness) {
    if (!rows.occlusion.empty()) rows.occlusion[i] = occlusion;
    if (!rows.metalness.empty()) rows.metalness[i] = metalness;
  };
  switch (role) {
    case TextureRole::kNormal: {
      glm::vec3& n = rows.normals[i];
      n = {component(texel.x), turned_y(settings, component(texel.y)), component(texel.z)};
      if (settings.texels == MaterialTexels::kBlocks) n.z = rebuilt_z(n);
      return;
    }
    case TextureRole::kOrm:
      rows.roughness[i] = texel.y;
      set_maps(texel.x, texel.z);
      return;
    case TextureRole::kMask:
      rows.roughness[i] = 1.0f - texel.w;
      set_maps(texel.y, texel.x);
      return;
    case TextureRole::kRoughness: rows.roughness[i] = texel.x; return;
    case TextureRole::kSmoothness: rows.roughness[i] = 1.0f - texel.x; return;
    case TextureRole::kOcclusion: rows.occlusion[i] = texel.x; return;
    case TextureRole::kMetalness: rows.metalness[i] = texel.x; return;
    case TextureRole::kAnisotropy:
      rows.anisotropy[i] = {component(texel.x), turned_y(settings, component(texel.y)), texel.z};
      return;
  }
}

// Writes one image per level.
template <typename Writer>
class TextureImages : public TextureFiles {
 public:
  TextureImages(const std::vector<std::string>& paths, int width, int height, int channels) : channels_(channels) {
    for (const std::string& path : paths) {
      const int level = static_cast<int>(levels_.size());
      levels_.push_back(
          std::make_unique<Writer>(path, mip_level_size(width, level), mip_level_size(height, level), channels));
    }
  }

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    constexpr bool kIsPng = std::is_same_v<Writer, Png8Writer>;
    std::vector<std::conditional_t<kIsPng, std::uint8_t, float>> codes;
    codes.reserve(size_of(channels_) * texels.size());
    for (const glm::vec4& texel : texels)
      for (int c = 0; c < channels_; ++c) {
        if constexpr (kIsPng) codes.push_back(code_of(texel[c]));
        else codes.push_back(texel[c]);
      }
    levels_[size_of(level)]->write_rows(row_count, codes.data());
  }
  // The file of the finest level is renamed last, so that a program that waits for this file finds all other files.
  void finish() override {
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) (*level)->finish();
  }

 private:
  const int channels_;
  std::vector<std::unique_ptr<Writer>> levels_;
};

// Writes all levels to one file.
class TextureLevels : public TextureFiles {
 public:
  TextureLevels(TexelFormat format, std::unique_ptr<TextureFile> file)
      : info_(info_of(format)), file_(std::move(file)) {}

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    if (info_.is_float) file_->write_rows(level, row_count, codes<std::uint16_t>(texels, clamped_to_half).data());
    else file_->write_rows(level, row_count, codes<std::uint8_t>(texels, code_of).data());
  }
  void finish() override { file_->finish(); }

 private:
  template <typename Code>
  std::vector<Code> codes(const std::vector<glm::vec4>& texels, Code (*code)(float)) const {
    std::vector<Code> codes;
    codes.reserve(texels.size() * size_of(info_.channels));
    for (const glm::vec4& texel : texels)
      for (int c = 0; c < info_.channels; ++c) codes.push_back(code(texel[c]));
    return codes;
  }

  const TexelFormatInfo& info_;
  std::unique_ptr<TextureFile> file_;
};

// Writes all levels to one file in a block format.
class TextureBlocks : public TextureFiles {
 public:
  TextureBlocks(const LeveledTexture& texture, BlockColour colour, BlockEncoder& encoder,
                std::unique_ptr<TextureFile> file)
      : texture_(texture), colour_(colour), encoder_(encoder), file_(std::move(file)) {}

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    const int width = mip_level_size(texture_.width, level), side = info_of(texture_.format).block_side;
    const std::vector<std::uint8_t> blocks = encoder_.encode(texture_.format, width, row_count, texels, colour_);
    file_->write_rows(level, (row_count + side - 1) / side, blocks.data());
    const std::uint8_t* block = blocks.data();
    for (int y = 0; y < row_count; y += side)
      for (int x = 0; x < width; x += side, block += info_of(texture_.format).block_bytes) {
        const BlockTexels decoded = decode_block(texture_.format, block);
        for (int j = 0; j < std::min(side, row_count - y); ++j)
          for (int i = 0; i < std::min(side, width - x); ++i)
            texels[size_of(y + j) * size_of(width) + size_of(x + i)] = decoded[size_of(j * side + i)];
      }
  }
  void finish() override { file_->finish(); }

 private:
  const LeveledTexture texture_;
  const BlockColour colour_;
  BlockEncoder& encoder_;
  std::unique_ptr<TextureFile> file_;
};

// Writes all levels to one file in UASTC. The levels wait in a temporary file until another program encodes them.
class TextureUastc : public TextureFiles {
 public:
  TextureUastc(const std::string& name, const LeveledTexture& texture, const UastcSettings& uastc,
               std::unique_ptr<TextureFile> file)
      : texture_(texture),
        uastc_(uastc),
        levels_(uastc.folder, name + ".levels", texture.width, texture.height),
        decoded_(uastc.folder, name + ".decoded", texture.width, texture.height),
        rows_(size_of(texture.level_count), 0),
        file_(std::move(file)) {}

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    std::vector<std::uint8_t> codes;
    codes.reserve(4 * texels.size());
    for (const glm::vec4& texel : texels)
      for (int c = 0; c < 4; ++c) codes.push_back(code_of(texel[c]));
    levels_.write_rows(level, rows_[size_of(level)], codes);
    rows_[size_of(level)] += row_count;
  }
  void encode(Progress* progress) override {
    const std::vector<std::vector<std::uint8_t>> blocks = encode_uastc(levels_, uastc_, progress, &decoded_);
    for (int level = 0; level < texture_.level_count; ++level)
      file_->write_rows(level, block_rows(texture_, level), blocks[size_of(level)].data());
  }
  std::vector<glm::vec4> stored_rows(int level, int first_row, int row_count) const override {
    const std::vector<std::uint8_t> codes = decoded_.read_rows(level, first_row, row_count);
    std::vector<glm::vec4> texels;
    texels.reserve(codes.size() / 4);
    for (std::size_t i = 0; i < codes.size(); i += 4)
      texels.push_back(glm::vec4(codes[i], codes[i + 1], codes[i + 2], codes[i + 3]) / 255.0f);
    return texels;
  }
  void finish() override { file_->finish(); }

 private:
  const LeveledTexture texture_;
  const UastcSettings uastc_;
  LevelFile levels_, decoded_;
  std::vector<int> rows_;  // rows written so far, by level
  std::unique_ptr<TextureFile> file_;
};

bool has_all_levels(MaterialFormat format) { return format == MaterialFormat::kKtx2 || format == MaterialFormat::kDds; }

}  // namespace

std::vector<TextureRole> roles_of(const MaterialFolderSettings& settings) {
  std::vector<TextureRole> roles = {TextureRole::kNormal};
  switch (settings.packing) {
    case MaterialPacking::kOrm: roles.push_back(TextureRole::kOrm); break;
    case MaterialPacking::kMask: roles.push_back(TextureRole::kMask); break;
    case MaterialPacking::kSeparate: roles.push_back(TextureRole::kRoughness); break;
    case MaterialPacking::kSmoothness: roles.push_back(TextureRole::kSmoothness); break;
  }
  if (settings.packing == MaterialPacking::kSeparate || settings.packing == MaterialPacking::kSmoothness) {
    if (settings.has_occlusion) roles.push_back(TextureRole::kOcclusion);
    if (settings.has_metalness) roles.push_back(TextureRole::kMetalness);
  }
  if (settings.has_anisotropy) roles.push_back(TextureRole::kAnisotropy);
  return roles;
}

std::vector<std::string> texture_files(const MaterialFolderSettings& settings, TextureRole role, int level_count) {
  const std::string stem = settings.folder + "/" + texture_name(settings.names, settings.material, role);
  const char* const extension = choice_name(kMaterialFormats, settings.format);
  if (has_all_levels(settings.format)) return {fmt::format("{}.{}", stem, extension)};
  std::vector<std::string> files;
  for (int level = 0; level < level_count; ++level) files.push_back(fmt::format("{}_{:02}.{}", stem, level, extension));
  return files;
}

std::vector<glm::vec4> texels_of(TextureRole role, const MaterialFolderSettings& settings, const MaterialRows& rows) {
  std::vector<glm::vec4> texels(rows.normals.size());
  for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = texel_of(role, settings, rows, i);
  return texels;
}

void set_rows(TextureRole role, const MaterialFolderSettings& settings, const std::vector<glm::vec4>& texels,
              MaterialRows& rows) {
  for (std::size_t i = 0; i < texels.size(); ++i) set_texel(role, settings, texels[i], rows, i);
}

std::vector<glm::vec4> TextureFiles::stored_rows(int, int, int) const { MULTUM_CHECK(false); }

std::unique_ptr<TextureFiles> make_texture(const MaterialFolderSettings& settings, TextureRole role, int width,
                                           int height, BlockEncoder& encoder) {
  const int level_count = mip_level_count(width, height);
  const std::vector<std::string> files = texture_files(settings, role, level_count);
  if (settings.format == MaterialFormat::kPng)
    return std::make_unique<TextureImages<Png8Writer>>(files, width, height, image_channels(role));
  if (settings.format == MaterialFormat::kExr)
    return std::make_unique<TextureImages<ExrHalfWriter>>(files, width, height, image_channels(role));
  const TexelFormat format = texel_format(role, settings.texels);
  const LeveledTexture texture{format, width, height, level_count, 0, role == TextureRole::kMask};
  std::unique_ptr<TextureFile> file =
      settings.format == MaterialFormat::kDds
          ? make_dds_file(files[0], texture)
          : make_ktx2_file(files[0], texture, {swizzle_of(format), settings.zstd_level});
  if (settings.texels == MaterialTexels::kUastc) {
    UastcSettings uastc = settings.uastc;
    uastc.has_normals = role == TextureRole::kNormal;
    return std::make_unique<TextureUastc>(name_of(role), texture, uastc, std::move(file));
  }
  if (settings.texels == MaterialTexels::kBlocks)
    return std::make_unique<TextureBlocks>(texture, role == TextureRole::kMask ? BlockColour::kRga : BlockColour::kRgb,
                                           encoder, std::move(file));
  return std::make_unique<TextureLevels>(format, std::move(file));
}

}  // namespace multum
