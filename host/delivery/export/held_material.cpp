// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/held_material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>
#include <utility>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr int kRowsAtOnce = 64;
constexpr float kMeanLeast = 0.01f;  // shortest usable mean; shorter means consist of rounding errors

// A texture that computes each texel on request.
class AskedTexture : public SharesTexture {
 public:
  using Ask = std::function<glm::dvec4(int level, int x, int y)>;
  AskedTexture(const TextureFrame& frame, Ask ask) : SharesTexture(frame), ask_(std::move(ask)) {}
  glm::dvec4 texel(int level, int x, int y) const override { return ask_(level, x, y); }

 private:
  const Ask ask_;
};

glm::dvec4 shares_of(const std::array<float, 3>& normal, double alpha) {
  return {0.5 + 0.5 * glm::dvec3(normal[0], normal[1], normal[2]), alpha};
}

void write_vectors(PlaneStore& store, int first_row, int row_count, const std::vector<glm::vec3>& vectors) {
  std::array<std::vector<float>, 3> planes;
  for (std::size_t p = 0; p < 3; ++p) {
    planes[p].reserve(vectors.size());
    for (const glm::vec3& v : vectors) planes[p].push_back(v[static_cast<int>(p)]);
  }
  store.write_rows(first_row, row_count, {planes[0].data(), planes[1].data(), planes[2].data()});
}
std::array<std::vector<float>, 3> read(const PlaneStore& store, int first_row, int row_count) {
  std::array<std::vector<float>, 3> planes;
  for (std::vector<float>& plane : planes) plane.resize(size_of(store.width()) * size_of(row_count));
  store.read_rows(first_row, row_count, {planes[0].data(), planes[1].data(), planes[2].data()});
  return planes;
}

}  // namespace

HeldMaterial::HeldMaterial(const OneLobeInputs& inputs, const OneLobeSettings& settings, bool has_unit_means,
                           const SpillPolicy& spill, MaterialSink* finest)
    : inputs_(inputs),
      finest_(finest),
      has_unit_means_(has_unit_means),
      base_(static_cast<float>(std::sqrt(std::max(kAlphaMin, settings.base_roughness * settings.base_roughness)))),
      frame_{inputs.normals->width(), inputs.normals->height(),
             mip_level_count(inputs.normals->width(), inputs.normals->height())} {
  MULTUM_CHECK(inputs.wants_means);
  for (int level = 1; level < frame_.level_count; ++level) {
    const int width = mip_level_size(frame_.width, level), height = mip_level_size(frame_.height, level);
    levels_.push_back({make_plane_store(width, height, spill), make_plane_store(width, height, spill),
                       make_plane_store(width, height, spill), std::nullopt});
    if (inputs.has_metalness) levels_.back().metalness = make_plane_store(width, height, spill);
  }
}

void HeldMaterial::add_level(int level, int first_row, MaterialRows rows) {
  if (level == 0) {
    if (finest_ != nullptr) finest_->add_level(level, first_row, std::move(rows));
    return;
  }
  Level& at = level_at(level);
  for (std::size_t i = 0; i < rows.means.size(); ++i) {
    const float length = glm::length(rows.means[i]);
    if (length < kMeanLeast) rows.means[i] = rows.normals[i];
    else if (has_unit_means_) rows.means[i] /= length;
  }
  write_vectors(at.normals, first_row, rows.height, rows.normals);
  write_vectors(at.means, first_row, rows.height, rows.means);
  const std::vector<float> plain(rows.roughness.size(), base_);
  const std::vector<float>& occlusion = rows.occlusion.empty() ? plain : rows.occlusion;
  at.values.write_rows(first_row, rows.height, {rows.roughness.data(), plain.data(), occlusion.data()});
  if (at.metalness)
    at.metalness->write_rows(first_row, rows.height,
                             {rows.metalness.data(), rows.metalness.data(), rows.metalness.data()});
}

HeldMaterial::Textures HeldMaterial::textures() const {
  return {std::make_unique<AskedTexture>(frame_, [this](int level, int x, int y) { return average_at(level, x, y); }),
          std::make_unique<AskedTexture>(frame_,
                                         [this](int level, int x, int y) {
                                           return level == 0 ? average_at(0, x, y)
                                                             : shares_of(level_at(level).normals.texel(x, y), 1.0);
                                         }),
          std::make_unique<AskedTexture>(frame_, [this](int level, int x, int y) { return surface_at(level, x, y); }),
          inputs_.has_metalness};
}

void HeldMaterial::pass(const NormalForm& form, MaterialSink& sink, Progress* progress) const {
  for (int level = 1; level < frame_.level_count; ++level) {
    const int height = mip_level_size(frame_.height, level);
    for (int row = 0; row < height; row += kRowsAtOnce) {
      progress_advance(progress, 0);
      const int count = std::min(kRowsAtOnce, height - row);
      sink.add_level(level, row, formed_rows(form.levels[size_of(level)], level, row, count));
    }
  }
}

double HeldMaterial::finest_roughness(int x, int y) const {
  if (!inputs_.has_roughness) return static_cast<double>(base_);
  const auto squared = static_cast<double>(inputs_.material->texel(x, y)[0]);  // alpha^2
  return std::sqrt(std::max(kAlphaMin, std::sqrt(squared)));
}
glm::dvec4 HeldMaterial::average_at(int level, int x, int y) const {
  if (level == 0) return shares_of(inputs_.normals->texel(x, y), finest_roughness(x, y));
  const Level& at = level_at(level);
  return shares_of(at.means.texel(x, y), static_cast<double>(at.values.texel(x, y)[1]));
}
glm::dvec4 HeldMaterial::surface_at(int level, int x, int y) const {
  const double roughness =
      level == 0 ? finest_roughness(x, y) : static_cast<double>(level_at(level).values.texel(x, y)[0]);
  double metalness = 1.0;
  if (inputs_.has_metalness)
    metalness =
        static_cast<double>(level == 0 ? inputs_.material->texel(x, y)[2] : level_at(level).metalness->texel(x, y)[0]);
  return {1.0, roughness, metalness, 1.0};
}

void HeldMaterial::average_roughness() {
  if (!inputs_.has_roughness) return;
  for (int level = 1; level < frame_.level_count; ++level) {
    const int height = mip_level_size(frame_.height, level);
    for_each_row_band(height, kRowsAtOnce, inputs_.threads,
                      [&](int, int begin, int end) { average_rows(level, begin, end - begin); });
  }
}

// Sets each texel to the average of the texels that it covers in the previous level.
void HeldMaterial::average_rows(int level, int first, int count) {
  Level& at = level_at(level);
  const int width = mip_level_size(frame_.width, level), height = mip_level_size(frame_.height, level);
  const int finer_width = mip_level_size(frame_.width, level - 1),
            finer_height = mip_level_size(frame_.height, level - 1);
  const auto edge = [](int index, int from, int to) { return static_cast<int>(std::int64_t{index} * from / to); };
  std::array<std::vector<float>, 3> values = read(at.values, first, count);
  for (int y = first; y < first + count; ++y) {
    const int top = edge(y, finer_height, height), bottom = edge(y + 1, finer_height, height);
    std::vector<float> finer(size_of(finer_width) * size_of(bottom - top));
    if (level > 1) level_at(level - 1).values.read_rows(1, top, bottom - top, finer.data());
    else inputs_.material->read_rows(0, top, bottom - top, finer.data());
    if (level == 1)
      for (float& value : finer) value = std::sqrt(std::max(static_cast<float>(kAlphaMin), std::sqrt(value)));
    for (int x = 0; x < width; ++x) {
      const int left = edge(x, finer_width, width), right = edge(x + 1, finer_width, width);
      float sum = 0.0f;
      for (int v = 0; v < bottom - top; ++v)
        for (int u = left; u < right; ++u) sum += finer[size_of(v) * size_of(finer_width) + size_of(u)];
      values[1][size_of(y - first) * size_of(width) + size_of(x)] =
          sum / static_cast<float>((bottom - top) * (right - left));
    }
  }
  at.values.write_rows(first, count, {values[0].data(), values[1].data(), values[2].data()});
}

MaterialRows HeldMaterial::formed_rows(const LevelForm& form, int level, int first_row, int row_count) const {
  const Level& at = level_at(level);
  const int width = mip_level_size(frame_.width, level);
  const std::size_t texels = size_of(width) * size_of(row_count);
  MaterialRows rows{width, row_count, std::vector<glm::vec3>(texels), std::vector<float>(texels), {}, {}, {}};
  const auto normals = read(form.has_fitted_normals ? at.normals : at.means, first_row, row_count);
  auto values = read(at.values, first_row, row_count);
  for (std::size_t i = 0; i < texels; ++i) {
    rows.normals[i] = {normals[0][i], normals[1][i], normals[2][i]};
    rows.roughness[i] = form.fitted_share == 1.0
                            ? values[0][i]
                            : static_cast<float>(mixed_roughness(static_cast<double>(values[1][i]),
                                                                 static_cast<double>(values[0][i]), form.fitted_share));
  }
  if (inputs_.has_occlusion) rows.occlusion = std::move(values[2]);
  if (at.metalness) rows.metalness = std::move(read(*at.metalness, first_row, row_count)[0]);
  return rows;
}

}  // namespace multum
