// SPDX-License-Identifier: Apache-2.0
#include "host/export/material_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include <glm/geometric.hpp>

#include "host/asset/baked_file.h"
#include "host/asset/exr/picture_file.h"
#include "host/base/half_bits.h"
#include "host/base/size_of.h"
#include "host/image/files/png_writer.h"

namespace multum {
namespace {

constexpr float kSteps = 255.0f;  // of 8 bits

float rounded_share(float value) { return std::round(std::clamp(value, 0.0f, 1.0f) * kSteps) / kSteps; }

// Of a component of a unit vector.
float rounded_component(float value) { return 2.0f * rounded_share(0.5f + 0.5f * value) - 1.0f; }

// One texture of one level: three channels of a texel.
class TextureImage {
 public:
  TextureImage(const std::string& path, TextureImageFormat format, int width, int height) {
    if (format == TextureImageFormat::kPng) png_.emplace(path, width, height);
    else exr_.emplace(path, width, height);
  }

  /// `texel(i)`: what is stored, in 8 bits as shares of 255.
  template <typename Texel>
  void write_rows(int width, int row_count, const Texel& texel) {
    const std::size_t texels = size_of(width) * size_of(row_count);
    std::vector<float> values(3 * texels);
    for (std::size_t i = 0; i < texels; ++i) {
      const glm::vec3 v = texel(i);
      values[3 * i] = v.x, values[3 * i + 1] = v.y, values[3 * i + 2] = v.z;
    }
    if (exr_) {
      exr_->write_rows(row_count, values.data());
      return;
    }
    std::vector<std::uint8_t> codes;
    for (const float v : values) codes.push_back(static_cast<std::uint8_t>(std::lround(v * kSteps)));
    png_->write_rows(row_count, codes.data());
  }
  void finish() {
    if (png_) png_->finish();
    else exr_->finish();
  }

 private:
  std::optional<Png8Writer> png_;
  std::optional<ExrHalfWriter> exr_;
};

std::vector<const char*> texture_names(bool has_anisotropy) {
  return has_anisotropy ? std::vector{"normal", "orm", "anisotropy"} : std::vector{"normal", "orm"};
}

class MaterialFolder : public MaterialWriter {
 public:
  MaterialFolder(const MaterialFolderSettings& settings, int width, int height) : settings_(settings) {
    const std::vector<std::string> files = material_files(settings, width, height);
    const int levels = mip_level_count(width, height);
    for (std::size_t i = 0; i < files.size(); ++i) {
      const int level = static_cast<int>(i % size_of(levels));
      images_.push_back(std::make_unique<TextureImage>(files[i], settings.format, mip_level_size(width, level),
                                                       mip_level_size(height, level)));
    }
    level_count_ = size_of(levels);
  }

  void add_level(int level, int, MaterialRows rows) override {
    const bool is_unorm = encoding_of(settings_.format) == MaterialEncoding::kUnorm8;
    const auto component = [&](float v) { return is_unorm ? 0.5f + 0.5f * v : v; };
    image(0, level).write_rows(rows.width, rows.height, [&](std::size_t i) {
      const glm::vec3& n = rows.normals[i];
      return glm::vec3(component(n.x), component(n.y), component(n.z));
    });
    image(1, level).write_rows(rows.width, rows.height, [&](std::size_t i) {
      return glm::vec3(rows.occlusion.empty() ? 1.0f : rows.occlusion[i], rows.roughness[i],
                       rows.metalness.empty() ? 1.0f : rows.metalness[i]);
    });
    if (!settings_.has_anisotropy) return;
    image(2, level).write_rows(rows.width, rows.height, [&](std::size_t i) {
      const glm::vec3& a = rows.anisotropy[i];
      return glm::vec3(component(a.x), component(a.y), a.z);
    });
  }

  // The finest levels last: whoever waits for them finds all others.
  void commit() override {
    for (std::size_t level = level_count_; level-- > 0;)
      for (std::size_t texture = 0; texture * level_count_ < images_.size(); ++texture)
        images_[texture * level_count_ + level]->finish();
  }

 private:
  TextureImage& image(std::size_t texture, int level) { return *images_[texture * level_count_ + size_of(level)]; }

  const MaterialFolderSettings settings_;
  std::size_t level_count_;
  std::vector<std::unique_ptr<TextureImage>> images_;
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

MaterialEncoding encoding_of(TextureImageFormat format) {
  return format == TextureImageFormat::kPng ? MaterialEncoding::kUnorm8 : MaterialEncoding::kHalf;
}

std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height) {
  std::vector<std::string> files;
  for (const char* texture : texture_names(settings.has_anisotropy))
    for (int level = 0; level < mip_level_count(width, height); ++level)
      files.push_back(fmt::format("{}/{}_{:02}.{}", settings.folder, texture, level,
                                  settings.format == TextureImageFormat::kPng ? "png" : "exr"));
  return files;
}

std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height) {
  return std::make_unique<MaterialFolder>(settings, width, height);
}

}  // namespace multum
