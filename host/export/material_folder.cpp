// SPDX-License-Identifier: Apache-2.0
#include "host/export/material_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <glm/geometric.hpp>

#include "host/asset/baked_file.h"
#include "host/asset/exr/picture_file.h"
#include "host/base/half_bits.h"
#include "host/base/size_of.h"
#include "host/export/ktx2_file.h"
#include "host/image/files/png_writer.h"

namespace multum {
namespace {

constexpr float kSteps = 255.0f;  // of 8 bits

float rounded_share(float value) { return std::round(std::clamp(value, 0.0f, 1.0f) * kSteps) / kSteps; }

// Of a component of a unit vector.
float rounded_component(float value) { return 2.0f * rounded_share(0.5f + 0.5f * value) - 1.0f; }

std::uint8_t code_of(float share) { return static_cast<std::uint8_t>(std::lround(share * kSteps)); }

// The files of one texture.
class TextureFiles {
 public:
  virtual ~TextureFiles() = default;
  /// The next rows of a level, three values a texel; of 8 bits as shares of 255.
  virtual void write_rows(int level, int row_count, const std::vector<float>& values) = 0;
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

  void write_rows(int level, int row_count, const std::vector<float>& values) override {
    if constexpr (std::is_same_v<Writer, Png8Writer>) {
      std::vector<std::uint8_t> codes(values.size());
      std::transform(values.begin(), values.end(), codes.begin(), code_of);
      levels_[size_of(level)]->write_rows(row_count, codes.data());
    } else {
      levels_[size_of(level)]->write_rows(row_count, values.data());
    }
  }
  // The finest level last: whoever waits for it finds the others.
  void finish() override {
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) (*level)->finish();
  }

 private:
  std::vector<std::unique_ptr<Writer>> levels_;
};

// A KTX2 file of all levels.
class TextureKtx2 : public TextureFiles {
 public:
  TextureKtx2(const std::string& path, const Ktx2Texture& texture)
      : is_half_(texture.format == Ktx2Format::kRgba16f), file_(path, texture) {}

  void write_rows(int level, int row_count, const std::vector<float>& values) override {
    if (is_half_) file_.write_rows(level, row_count, with_alpha<std::uint16_t>(values, clamped_to_half).data());
    else file_.write_rows(level, row_count, with_alpha<std::uint8_t>(values, code_of).data());
  }
  void finish() override { file_.finish(); }

 private:
  template <typename Code>
  static std::vector<Code> with_alpha(const std::vector<float>& values, Code (*code)(float)) {
    std::vector<Code> codes;
    codes.reserve(values.size() / 3 * 4);
    for (std::size_t i = 0; i < values.size(); i += 3) {
      for (std::size_t c = 0; c < 3; ++c) codes.push_back(code(values[i + c]));
      codes.push_back(code(1.0f));
    }
    return codes;
  }

  const bool is_half_;
  Ktx2File file_;
};

std::vector<const char*> texture_names(bool has_anisotropy) {
  return has_anisotropy ? std::vector{"normal", "orm", "anisotropy"} : std::vector{"normal", "orm"};
}

std::vector<std::string> texture_files(const MaterialFolderSettings& settings, const char* texture, int level_count) {
  const std::string stem = settings.folder + "/" + texture;
  if (settings.format == MaterialFormat::kKtx2 || settings.format == MaterialFormat::kKtx2Half) return {stem + ".ktx2"};
  std::vector<std::string> files;
  for (int level = 0; level < level_count; ++level)
    files.push_back(fmt::format("{}_{:02}.{}", stem, level, settings.format == MaterialFormat::kPng ? "png" : "exr"));
  return files;
}

std::unique_ptr<TextureFiles> make_texture(const MaterialFolderSettings& settings, const char* texture, int width,
                                           int height) {
  const int level_count = mip_level_count(width, height);
  const std::vector<std::string> files = texture_files(settings, texture, level_count);
  switch (settings.format) {
    case MaterialFormat::kPng: return std::make_unique<TextureImages<Png8Writer>>(files, width, height);
    case MaterialFormat::kExr: return std::make_unique<TextureImages<ExrHalfWriter>>(files, width, height);
    case MaterialFormat::kKtx2:
      return std::make_unique<TextureKtx2>(files[0], Ktx2Texture{Ktx2Format::kRgba8, width, height, level_count});
    case MaterialFormat::kKtx2Half: break;
  }
  return std::make_unique<TextureKtx2>(files[0], Ktx2Texture{Ktx2Format::kRgba16f, width, height, level_count});
}

class MaterialFolder : public MaterialWriter {
 public:
  MaterialFolder(const MaterialFolderSettings& settings, int width, int height) : settings_(settings) {
    for (const char* texture : texture_names(settings.has_anisotropy))
      textures_.push_back(make_texture(settings, texture, width, height));
  }

  void add_level(int level, int, MaterialRows rows) override {
    const bool is_unorm = encoding_of(settings_.format) == MaterialEncoding::kUnorm8;
    const auto component = [&](float v) { return is_unorm ? 0.5f + 0.5f * v : v; };
    write(0, level, rows, [&](std::size_t i) {
      const glm::vec3& n = rows.normals[i];
      return glm::vec3(component(n.x), component(n.y), component(n.z));
    });
    write(1, level, rows, [&](std::size_t i) {
      return glm::vec3(rows.occlusion.empty() ? 1.0f : rows.occlusion[i], rows.roughness[i],
                       rows.metalness.empty() ? 1.0f : rows.metalness[i]);
    });
    if (!settings_.has_anisotropy) return;
    write(2, level, rows, [&](std::size_t i) {
      const glm::vec3& a = rows.anisotropy[i];
      return glm::vec3(component(a.x), component(a.y), a.z);
    });
  }

  void commit() override {
    for (const std::unique_ptr<TextureFiles>& texture : textures_) texture->finish();
  }

 private:
  template <typename Texel>
  void write(std::size_t texture, int level, const MaterialRows& rows, const Texel& texel) {
    std::vector<float> values;
    values.reserve(3 * rows.normals.size());
    for (std::size_t i = 0; i < rows.normals.size(); ++i) {
      const glm::vec3 v = texel(i);
      values.insert(values.end(), {v.x, v.y, v.z});
    }
    textures_[texture]->write_rows(level, rows.height, values);
  }

  const MaterialFolderSettings settings_;
  std::vector<std::unique_ptr<TextureFiles>> textures_;
};

}  // namespace

void round_material(MaterialRows& rows, MaterialEncoding encoding) {
  const bool is_unorm = encoding == MaterialEncoding::kUnorm8;
  const auto share = [&](float v) { return is_unorm ? rounded_share(v) : half_to_float(clamped_to_half(v)); };
  const auto component = [&](float v) { return is_unorm ? rounded_component(v) : half_to_float(clamped_to_half(v)); };
  for (glm::vec3& n : rows.normals) n = {component(n.x), component(n.y), component(n.z)};
  for (glm::vec3& a : rows.anisotropy) a = {component(a.x), component(a.y), share(a.z)};
  for (std::vector<float>* plane : {&rows.roughness, &rows.occlusion, &rows.metalness})
    for (float& value : *plane) value = share(value);
}

MaterialEncoding encoding_of(MaterialFormat format) {
  return format == MaterialFormat::kPng || format == MaterialFormat::kKtx2 ? MaterialEncoding::kUnorm8
                                                                           : MaterialEncoding::kHalf;
}

std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height) {
  std::vector<std::string> files;
  for (const char* texture : texture_names(settings.has_anisotropy))
    for (std::string& file : texture_files(settings, texture, mip_level_count(width, height)))
      files.push_back(std::move(file));
  return files;
}

std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height) {
  return std::make_unique<MaterialFolder>(settings, width, height);
}

}  // namespace multum
