// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/material_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include <glm/vec4.hpp>

#include "host/delivery/export/block_encoder.h"
#include "host/delivery/export/material_textures.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

float rounded_share(float value) { return static_cast<float>(code_of(std::clamp(value, 0.0f, 1.0f))) / 255.0f; }

// Rounds a component of a unit vector.
float rounded_component(float value) { return 2.0f * rounded_share(0.5f + 0.5f * value) - 1.0f; }

// Appends rows.
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

// Removes the first rows and returns them.
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
      : settings_(settings), width_(width), height_(height), stored_(stored), encoder_(device) {
    MULTUM_CHECK(can_store(settings.format, settings.texels));
    for (const TextureRole role : roles_of(settings)) {
      roles_.push_back(role);
      textures_.push_back(make_texture(settings, role, width, height, encoder_));
    }
    waiting_.resize(size_of(mip_level_count(width, height)));
  }

  void add_level(int level, int first_row, MaterialRows rows) override {
    has_occlusion_ = !rows.occlusion.empty();
    has_metalness_ = !rows.metalness.empty();
    if (settings_.texels != MaterialTexels::kBlocks) {
      round_material(rows, settings_.texels);
      write(level, first_row, std::move(rows));
      return;
    }
    // Rows wait here until they fill blocks.
    MaterialRows& waiting = waiting_[size_of(level)];
    const int first = first_row - waiting.height;
    append(waiting, rows);
    const bool is_end = first + waiting.height == mip_level_size(height_, level);
    const int ready = is_end ? waiting.height : waiting.height / kBlockSide * kBlockSide;
    if (ready > 0) write(level, first, take_rows(waiting, ready));
  }

  void encode(Progress* progress) override {
    if (!is_encoded_whole()) return;
    for (const std::unique_ptr<TextureFiles>& texture : textures_) texture->encode(progress);
    if (stored_ == nullptr) return;
    for (int level = 0; level < static_cast<int>(waiting_.size()); ++level) {
      const int height = mip_level_size(height_, level);
      for (int row = 0; row < height; row += kRowsAtOnce)
        stored_->add_level(level, row, stored_rows(level, row, std::min(kRowsAtOnce, height - row)));
    }
  }

  void commit() override {
    for (const std::unique_ptr<TextureFiles>& texture : textures_) texture->finish();
  }

 private:
  static constexpr int kBlockSide = 4;
  static constexpr int kRowsAtOnce = 64;

  bool is_encoded_whole() const { return settings_.texels == MaterialTexels::kUastc; }

  // Returns stored rows of textures that are encoded as a whole.
  MaterialRows stored_rows(int level, int first_row, int row_count) const {
    const int width = mip_level_size(width_, level);
    const std::size_t count = size_of(width) * size_of(row_count);
    MaterialRows rows{width, row_count, std::vector<glm::vec3>(count), std::vector<float>(count), {}, {}, {}};
    if (settings_.has_anisotropy) rows.anisotropy.resize(count);
    if (has_occlusion_) rows.occlusion.resize(count);
    if (has_metalness_) rows.metalness.resize(count);
    for (std::size_t t = 0; t < textures_.size(); ++t)
      set_rows(roles_[t], settings_, textures_[t]->stored_rows(level, first_row, row_count), rows);
    return rows;
  }

  void write(int level, int first_row, MaterialRows rows) {
    for (std::size_t t = 0; t < textures_.size(); ++t) {
      std::vector<glm::vec4> texels = texels_of(roles_[t], settings_, rows);
      textures_[t]->write_rows(level, rows.height, texels);
      if (settings_.texels == MaterialTexels::kBlocks) set_rows(roles_[t], settings_, texels, rows);
    }
    if (stored_ != nullptr && !is_encoded_whole()) stored_->add_level(level, first_row, std::move(rows));
  }

  const MaterialFolderSettings settings_;
  const int width_, height_;
  MaterialSink* const stored_;
  BlockEncoder encoder_;
  std::vector<TextureRole> roles_;
  std::vector<std::unique_ptr<TextureFiles>> textures_;
  std::vector<MaterialRows> waiting_;  // by level
  bool has_occlusion_ = false, has_metalness_ = false;
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
  if (texels == MaterialTexels::kUastc) return format == MaterialFormat::kKtx2;
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

void check_sides(SideRule rule, const std::string& path, int width, int height) {
  const auto is_legal = [&](int side) {
    return rule == SideRule::kAny || (rule == SideRule::kMultiplesOf4 ? side % 4 == 0 : is_power_of_two(side));
  };
  if (is_legal(width) && is_legal(height)) return;
  refuse_file(path, fmt::format("found {} x {} texels, expected {} with --sides {}: the engine would load only level 0 "
                                "of other sizes, or nothing. Resize the map, or use --sides any",
                                width, height, rule == SideRule::kPowersOf2 ? "powers of 2" : "multiples of 4",
                                choice_name(kSideRules, rule)));
}

std::vector<std::string> side_warnings(const MaterialFolderSettings& settings, int width, int height) {
  std::vector<std::string> warnings;
  const std::string sides = fmt::format("its sides are {} x {}: ", width, height);
  if (settings.format == MaterialFormat::kKtx2 && !(is_power_of_two(width) && is_power_of_two(height)))
    warnings.push_back(sides +
                       "Godot keeps only level 0 of KTX2 files unless the sides are powers of two, and computes its "
                       "own mips; resize the map first if you use Godot");
  const bool has_blocks = settings.texels == MaterialTexels::kBlocks || settings.texels == MaterialTexels::kUastc;
  if (has_blocks && (width % 4 != 0 || height % 4 != 0))
    warnings.push_back(sides +
                       "Direct3D, and browsers that use Direct3D, reject block-compressed textures unless their sides "
                       "are multiples of 4; resize the map first");
  return warnings;
}

std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height,
                                                     Device& device, MaterialSink* stored) {
  return std::make_unique<MaterialFolder>(settings, width, height, device, stored);
}

}  // namespace multum
