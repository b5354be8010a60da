// SPDX-License-Identifier: Apache-2.0
#include "host/export/material_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <glm/vec4.hpp>

#include "host/asset/baked_file.h"
#include "host/asset/exr/picture_file.h"
#include "host/base/error.h"
#include "host/base/half_bits.h"
#include "host/base/size_of.h"
#include "host/export/block_decoding.h"
#include "host/export/block_encoder.h"
#include "host/export/texture_file.h"
#include "host/image/files/png_writer.h"

namespace multum {
namespace {

constexpr float kSteps = 255.0f;  // of 8 bits

// To the nearest step of 8 bits, of values from 0 to 1. std::lround, a call, would be a twelfth of an export's time.
std::uint8_t code_of(float share) { return static_cast<std::uint8_t>(share * kSteps + 0.5f); }

float rounded_share(float value) { return static_cast<float>(code_of(std::clamp(value, 0.0f, 1.0f))) / kSteps; }

// Of a component of a unit vector.
float rounded_component(float value) { return 2.0f * rounded_share(0.5f + 0.5f * value) - 1.0f; }

bool is_half(MaterialTexels texels) { return texels == MaterialTexels::kRgba16f; }

enum class TextureRole { kNormal, kOrm, kRoughness, kAnisotropy };

const char* name_of(TextureRole role) {
  switch (role) {
    case TextureRole::kNormal: return "normal";
    case TextureRole::kOrm: return "orm";
    case TextureRole::kRoughness: return "roughness";
    case TextureRole::kAnisotropy: return "anisotropy";
  }
  MULTUM_CHECK(false);
}

std::vector<TextureRole> roles_of(const MaterialFolderSettings& settings) {
  std::vector<TextureRole> roles = {TextureRole::kNormal,
                                    settings.has_roughness_alone ? TextureRole::kRoughness : TextureRole::kOrm};
  if (settings.has_anisotropy) roles.push_back(TextureRole::kAnisotropy);
  return roles;
}

// Of KTX2 and DDS.
TexelFormat texel_format(TextureRole role, MaterialTexels texels) {
  const bool has_blocks = texels == MaterialTexels::kBlocks;
  if (is_half(texels)) return TexelFormat::kRgba16f;
  if (role == TextureRole::kRoughness) return has_blocks ? TexelFormat::kBc4 : TexelFormat::kR8;
  if (role == TextureRole::kNormal && has_blocks) return TexelFormat::kBc5;
  if (role == TextureRole::kNormal && texels == MaterialTexels::kRg8) return TexelFormat::kRg8;
  return has_blocks ? TexelFormat::kBc7 : TexelFormat::kRgba8;
}

// What a shader sees of channels that are not stored, of readers that obey: normals that nobody rebuilds point up
// rather than down, roughness is in whichever channel somebody looks for it.
std::string swizzle_of(TexelFormat format) {
  const int channels = info_of(format).channels;
  return channels == 1 ? "rrr1" : channels == 2 ? "rg11" : "";
}

// Red, green, blue, alpha as they are stored, those of 8 bits as shares.
glm::vec4 texel_of(TextureRole role, MaterialTexels texels, const MaterialRows& rows, std::size_t i) {
  const auto component = [&](float v) { return is_half(texels) ? v : 0.5f + 0.5f * v; };
  switch (role) {
    case TextureRole::kNormal: {
      const glm::vec3& n = rows.normals[i];
      return {component(n.x), component(n.y), component(n.z), 1.0f};
    }
    case TextureRole::kOrm:
      return {rows.occlusion.empty() ? 1.0f : rows.occlusion[i], rows.roughness[i],
              rows.metalness.empty() ? 1.0f : rows.metalness[i], 1.0f};
    case TextureRole::kRoughness: return {rows.roughness[i], rows.roughness[i], rows.roughness[i], 1.0f};
    case TextureRole::kAnisotropy: {
      const glm::vec3& a = rows.anisotropy[i];
      return {component(a.x), component(a.y), a.z, 1.0f};
    }
  }
  MULTUM_CHECK(false);
}

// z of a unit normal, from the other two.
float rebuilt_z(const glm::vec3& n) { return std::sqrt(std::max(0.0f, 1.0f - n.x * n.x - n.y * n.y)); }

// The other way round, of texels that are stored as blocks.
void set_texel(TextureRole role, const glm::vec4& texel, MaterialRows& rows, std::size_t i) {
  const auto component = [](float share) { return 2.0f * share - 1.0f; };
  switch (role) {
    case TextureRole::kNormal:
      rows.normals[i] = {component(texel.x), component(texel.y), 0.0f};
      rows.normals[i].z = rebuilt_z(rows.normals[i]);
      return;
    case TextureRole::kOrm:
      rows.roughness[i] = texel.y;
      if (!rows.occlusion.empty()) rows.occlusion[i] = texel.x;
      if (!rows.metalness.empty()) rows.metalness[i] = texel.z;
      return;
    case TextureRole::kRoughness: rows.roughness[i] = texel.x; return;
    case TextureRole::kAnisotropy: rows.anisotropy[i] = {component(texel.x), component(texel.y), texel.z}; return;
  }
}

// The files of one texture.
class TextureFiles {
 public:
  virtual ~TextureFiles() = default;
  /// The next rows of a level, rounded; of blocks whole ones, or the level's last. They become what is stored.
  virtual void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) = 0;
  /// Gives them their names.
  virtual void finish() = 0;
};

// An image a level.
template <typename Writer>
class TextureImages : public TextureFiles {
 public:
  TextureImages(const std::vector<std::string>& paths, int width, int height) {
    for (const std::string& path : paths) {
      const int level = static_cast<int>(levels_.size());
      levels_.push_back(std::make_unique<Writer>(path, mip_level_size(width, level), mip_level_size(height, level)));
    }
  }

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    constexpr bool kIsPng = std::is_same_v<Writer, Png8Writer>;
    std::vector<std::conditional_t<kIsPng, std::uint8_t, float>> codes;
    codes.reserve(3 * texels.size());
    for (const glm::vec4& texel : texels)
      for (int c = 0; c < 3; ++c) {
        if constexpr (kIsPng) codes.push_back(code_of(texel[c]));
        else codes.push_back(texel[c]);
      }
    levels_[size_of(level)]->write_rows(row_count, codes.data());
  }
  // The finest level last: whoever waits for it finds the others.
  void finish() override {
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) (*level)->finish();
  }

 private:
  std::vector<std::unique_ptr<Writer>> levels_;
};

// A file of all levels.
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

// A file of all levels in blocks.
class TextureBlocks : public TextureFiles {
 public:
  TextureBlocks(const LeveledTexture& texture, BlockEncoder& encoder, std::unique_ptr<TextureFile> file)
      : texture_(texture), encoder_(encoder), file_(std::move(file)) {}

  void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) override {
    const int width = mip_level_size(texture_.width, level), side = info_of(texture_.format).block_side;
    const std::vector<std::uint8_t> blocks = encoder_.encode(texture_.format, width, row_count, texels);
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
  BlockEncoder& encoder_;
  std::unique_ptr<TextureFile> file_;
};

bool has_all_levels(MaterialFormat format) { return format == MaterialFormat::kKtx2 || format == MaterialFormat::kDds; }

std::vector<std::string> texture_files(const MaterialFolderSettings& settings, TextureRole role, int level_count) {
  const std::string stem = settings.folder + "/" + settings.name_prefix + name_of(role);
  if (has_all_levels(settings.format)) return {stem + (settings.format == MaterialFormat::kKtx2 ? ".ktx2" : ".dds")};
  std::vector<std::string> files;
  for (int level = 0; level < level_count; ++level)
    files.push_back(fmt::format("{}_{:02}.{}", stem, level, settings.format == MaterialFormat::kPng ? "png" : "exr"));
  return files;
}

std::unique_ptr<TextureFiles> make_texture(const MaterialFolderSettings& settings, TextureRole role, int width,
                                           int height, BlockEncoder& encoder) {
  const int level_count = mip_level_count(width, height);
  const std::vector<std::string> files = texture_files(settings, role, level_count);
  if (settings.format == MaterialFormat::kPng) return std::make_unique<TextureImages<Png8Writer>>(files, width, height);
  if (settings.format == MaterialFormat::kExr)
    return std::make_unique<TextureImages<ExrHalfWriter>>(files, width, height);
  const TexelFormat format = texel_format(role, settings.texels);
  const LeveledTexture texture{format, width, height, level_count};
  std::unique_ptr<TextureFile> file =
      settings.format == MaterialFormat::kDds
          ? make_dds_file(files[0], texture)
          : make_ktx2_file(files[0], texture, {swizzle_of(format), settings.zstd_level});
  if (settings.texels == MaterialTexels::kBlocks)
    return std::make_unique<TextureBlocks>(texture, encoder, std::move(file));
  return std::make_unique<TextureLevels>(format, std::move(file));
}

// Adds rows to those before.
void append(MaterialRows& to, const MaterialRows& more) {
  to.width = more.width;
  to.height += more.height;
  const auto add = [](auto& values, const auto& others) { values.insert(values.end(), others.begin(), others.end()); };
  add(to.normals, more.normals);
  add(to.roughness, more.roughness);
  add(to.anisotropy, more.anisotropy);
  add(to.occlusion, more.occlusion);
  add(to.metalness, more.metalness);
}

// Takes the first rows away, and returns them.
MaterialRows take_rows(MaterialRows& from, int row_count) {
  MaterialRows taken{from.width, row_count, {}, {}, {}, {}, {}};
  const std::size_t count = size_of(from.width) * size_of(row_count);
  const auto take = [&](auto& to, auto& values) {
    if (values.empty()) return;
    to.assign(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count));
  };
  take(taken.normals, from.normals);
  take(taken.roughness, from.roughness);
  take(taken.anisotropy, from.anisotropy);
  take(taken.occlusion, from.occlusion);
  take(taken.metalness, from.metalness);
  from.height -= row_count;
  return taken;
}

class MaterialFolder : public MaterialWriter {
 public:
  MaterialFolder(const MaterialFolderSettings& settings, int width, int height, Device& device, MaterialSink* stored)
      : settings_(settings), height_(height), stored_(stored), encoder_(device) {
    MULTUM_CHECK(can_store(settings.format, settings.texels));
    for (const TextureRole role : roles_of(settings)) {
      roles_.push_back(role);
      textures_.push_back(make_texture(settings, role, width, height, encoder_));
    }
    waiting_.resize(size_of(mip_level_count(width, height)));
  }

  void add_level(int level, int first_row, MaterialRows rows) override {
    if (settings_.texels != MaterialTexels::kBlocks) {
      round_material(rows, settings_.texels);
      write(level, first_row, std::move(rows));
      return;
    }
    // Rows wait until they fill blocks.
    MaterialRows& waiting = waiting_[size_of(level)];
    const int first = first_row - waiting.height;
    append(waiting, rows);
    const bool is_end = first + waiting.height == mip_level_size(height_, level);
    const int ready = is_end ? waiting.height : waiting.height / kBlockSide * kBlockSide;
    if (ready > 0) write(level, first, take_rows(waiting, ready));
  }

  void commit() override {
    for (const std::unique_ptr<TextureFiles>& texture : textures_) texture->finish();
  }

 private:
  static constexpr int kBlockSide = 4;

  void write(int level, int first_row, MaterialRows rows) {
    std::vector<glm::vec4> texels(rows.normals.size());
    for (std::size_t t = 0; t < textures_.size(); ++t) {
      for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = texel_of(roles_[t], settings_.texels, rows, i);
      textures_[t]->write_rows(level, rows.height, texels);
      if (settings_.texels != MaterialTexels::kBlocks) continue;
      for (std::size_t i = 0; i < texels.size(); ++i) set_texel(roles_[t], texels[i], rows, i);
    }
    if (stored_ != nullptr) stored_->add_level(level, first_row, std::move(rows));
  }

  const MaterialFolderSettings settings_;
  const int height_;
  MaterialSink* const stored_;
  BlockEncoder encoder_;
  std::vector<TextureRole> roles_;
  std::vector<std::unique_ptr<TextureFiles>> textures_;
  std::vector<MaterialRows> waiting_;  // by level
};

bool is_power_of_two(int side) { return std::has_single_bit(static_cast<unsigned>(side)); }

}  // namespace

void round_material(MaterialRows& rows, MaterialTexels texels) {
  const bool halves = is_half(texels);
  const auto share = [&](float v) { return halves ? half_to_float(clamped_to_half(v)) : rounded_share(v); };
  const auto component = [&](float v) { return halves ? half_to_float(clamped_to_half(v)) : rounded_component(v); };
  for (glm::vec3& n : rows.normals) {
    n = {component(n.x), component(n.y), component(n.z)};
    if (texels == MaterialTexels::kRg8) n.z = rebuilt_z(n);
  }
  for (glm::vec3& a : rows.anisotropy) a = {component(a.x), component(a.y), share(a.z)};
  for (std::vector<float>* plane : {&rows.roughness, &rows.occlusion, &rows.metalness})
    for (float& value : *plane) value = share(value);
}

bool can_store(MaterialFormat format, MaterialTexels texels) {
  if (format == MaterialFormat::kPng) return texels == MaterialTexels::kRgba8;
  return format != MaterialFormat::kExr || texels == MaterialTexels::kRgba16f;
}

std::string texture_list(const MaterialFolderSettings& settings) {
  std::string list;
  for (const TextureRole role : roles_of(settings)) list += (list.empty() ? "" : ", ") + std::string(name_of(role));
  return list;
}

std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height) {
  std::vector<std::string> files;
  for (const TextureRole role : roles_of(settings))
    for (std::string& file : texture_files(settings, role, mip_level_count(width, height)))
      files.push_back(std::move(file));
  return files;
}

std::vector<std::string> side_warnings(const MaterialFolderSettings& settings, int width, int height) {
  std::vector<std::string> warnings;
  const std::string sides = fmt::format("the map's sides are {} x {}: ", width, height);
  if (settings.format == MaterialFormat::kKtx2 && !(is_power_of_two(width) && is_power_of_two(height)))
    warnings.push_back(sides +
                       "of KTX2 files whose sides are no powers of two Godot keeps level 0 alone and makes mips of its "
                       "own; resize the map first if it is for Godot");
  if (settings.texels == MaterialTexels::kBlocks && (width % 4 != 0 || height % 4 != 0))
    warnings.push_back(sides +
                       "Direct3D refuses block-compressed textures whose sides are no multiples of 4, and so do "
                       "browsers that run on it; resize the map first");
  return warnings;
}

std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height,
                                                     Device& device, MaterialSink* stored) {
  return std::make_unique<MaterialFolder>(settings, width, height, device, stored);
}

}  // namespace multum
