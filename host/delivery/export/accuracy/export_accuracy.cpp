// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/export_accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/export_rules.h"
#include "host/delivery/export/accuracy/lobe_optimum.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

// Returns texel number `k` of `count` texels, which the R2 sequence spreads over a level (Roberts 2018).
struct Place {
  int x, y;
};
Place spread_place(int k, int width, int height) {
  const double s = 0.5 + 0.7548776662466927 * (k + 1), t = 0.5 + 0.5698402909980532 * (k + 1);
  return {static_cast<int>((s - std::floor(s)) * width), static_cast<int>((t - std::floor(t)) * height)};
}

std::vector<std::string> rule_ids(const BakedLobes* baked, bool finds_optimum) {
  std::vector<std::string> ids = {"export"};
  for (const EngineRule& rule : engine_rules()) ids.emplace_back(rule.id);
  if (baked != nullptr) ids.emplace_back("baked");
  if (finds_optimum) ids.insert(ids.end(), {"optimum_isotropic", "optimum_anisotropic"});
  return ids;
}

std::vector<std::string> rule_names(const BakedLobes* baked, bool finds_optimum) {
  std::vector<std::string> names = {"this export"};
  for (const EngineRule& rule : engine_rules()) names.emplace_back(rule.name);
  if (baked != nullptr) names.push_back(baked->name());
  if (finds_optimum) names.insert(names.end(), {"best found, isotropic", "best found, anisotropic"});
  return names;
}

nlohmann::ordered_json json_of(const LobeError& error) { return {{"error", error.error}, {"energy", error.energy}}; }

nlohmann::ordered_json json_of(const std::vector<std::string>& ids, const std::vector<RuleError>& errors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    json[ids[i]] = json_of(errors[i].point);
    json[ids[i]]["wide"] = json_of(errors[i].wide);
  }
  return json;
}

// Rounds an engine's isotropic lobe in the same way as the export's textures.
GgxLobe stored(const GgxLobe& lobe, const std::optional<MaterialTexels>& texels) {
  if (!texels) return lobe;
  MaterialRows rows;
  rows.normals = {glm::vec3(lobe.normal)};
  rows.roughness = {static_cast<float>(std::sqrt(lobe.alpha_wide))};
  // Compared with 8 bits per channel, a block stores its texels more exactly if they are similar, and less exactly if
  // they differ.
  round_material(rows, *texels == MaterialTexels::kBlocks ? MaterialTexels::kRgba8 : *texels);
  return lobe_of_texel(rows, 0);
}

void add(LobeError& sum, const LobeError& more, double share) {
  sum.error += share * more.error;
  sum.energy += share * more.energy;
}

}  // namespace

GgxLobe lobe_of_texel(const MaterialRows& rows, std::size_t i) {
  const double alpha =
      std::max(kAlphaMin, static_cast<double>(rows.roughness[i]) * static_cast<double>(rows.roughness[i]));
  GgxLobe lobe = GgxLobe::isotropic(glm::normalize(glm::dvec3(rows.normals[i])), alpha);
  if (rows.anisotropy.empty()) return lobe;
  const glm::dvec3 a(rows.anisotropy[i]);
  lobe.alpha_wide = alpha + (1.0 - alpha) * a.z * a.z;
  const double length = std::hypot(a.x, a.y);
  if (length > 1e-6) lobe.axis = (a.x * lobe.axis + a.y * glm::cross(lobe.normal, lobe.axis)) / length;
  return lobe;
}

ExportMeter::ExportMeter(int width, int height, const ExportAccuracySettings& settings, BakedLobes* baked)
    : settings_(settings), baked_(baked) {
  for (const int level : settings.levels) {
    if (level >= mip_level_count(width, height)) continue;
    const int w = mip_level_size(width, level), h = mip_level_size(height, level);
    const int count = static_cast<int>(std::min<std::int64_t>(settings.cells_per_level, std::int64_t{w} * h));
    for (int k = 0, found = 0; found < count; ++k) {
      const Place place = spread_place(k, w, h);
      const auto same = [&](const Cell& c) { return c.level == level && c.x == place.x && c.y == place.y; };
      if (std::any_of(cells_.begin(), cells_.end(), same)) continue;
      cells_.push_back({level, place.x, place.y, w, h, {}, {}});
      ++found;
    }
  }
}

void ExportMeter::add_level(int level, int first_row, MaterialRows rows) {
  for (Cell& cell : cells_)
    if (cell.level == level && cell.y >= first_row && cell.y < first_row + rows.height)
      cell.lobe = lobe_of_texel(rows, size_of(cell.y - first_row) * size_of(rows.width) + size_of(cell.x));
}

CellAccuracy ExportMeter::measure(const Cell& cell, const OneLobeInputs& inputs,
                                  const OneLobeSettings& settings) const {
  const double alpha = settings.base_roughness * settings.base_roughness;
  const CoveredFacets facets = covered_facets(inputs.fitted_normals(), inputs.has_roughness ? inputs.material : nullptr,
                                              alpha * alpha, cell.width, cell.height, cell.x, cell.y);
  // The lights are the same for all exports, so that exports of one map can be compared. A search uses different lights
  // than the measurement of its results.
  const std::uint64_t seed = split_mix(static_cast<std::uint64_t>(cell.level) << 40 |
                                       static_cast<std::uint64_t>(cell.y) << 20 | static_cast<std::uint64_t>(cell.x));
  const ReferenceLights points = point_lights(facets, settings_.lights_per_view, 2 * seed);
  const ReferenceLights wide = wide_lights(facets, settings_.wide_lights_per_view, 2 * seed);
  CellAccuracy measured{cell.level, cell.x, cell.y, points.noise, {}};
  std::vector<GgxLobe> lobes = {cell.lobe};
  for (const EngineRule& rule : engine_rules())
    lobes.push_back(stored(lobe_of_rule(rule, {facets.mean_normal, facets.mean_roughness}), settings_.texels));
  // Measures one GGX lobe under point lights and wide lights.
  const auto of_lobe = [&](const GgxLobe& lobe) {
    return RuleError{error_of_lobe(points, lobe), error_of_lobe(wide, lobe, kWideLightPoints)};
  };
  for (const GgxLobe& lobe : lobes) measured.errors.push_back(of_lobe(lobe));
  if (baked_ != nullptr) {
    const auto of_baked = [&](const LightSet& set, std::vector<double>& values) {
      lobe_highlights(set, cell.baked, facets.mean_roughness * facets.mean_roughness, values);
    };
    measured.errors.push_back(
        {error_of_highlights(points, of_baked), error_of_highlights(wide, of_baked, kWideLightPoints)});
  }
  if (settings_.finds_optimum) {
    const ReferenceLights seen = point_lights(facets, settings_.lights_per_view, 2 * seed + 1);
    const double alpha_round = std::sqrt(cell.lobe.alpha_wide * cell.lobe.alpha_narrow);
    const GgxLobe round{cell.lobe.normal, alpha_round, alpha_round, cell.lobe.axis};
    measured.errors.push_back(of_lobe(find_lobe_optimum(seen, round, false, kAlphaMin)));
    measured.errors.push_back(of_lobe(find_lobe_optimum(seen, cell.lobe, true, kAlphaMin)));
  }
  return measured;
}

ExportAccuracy ExportMeter::run(const OneLobeInputs& inputs, const OneLobeSettings& settings, Progress* progress) {
  ExportAccuracy accuracy;
  accuracy.lights_per_view = settings_.lights_per_view;
  accuracy.ids = rule_ids(baked_, settings_.finds_optimum);
  accuracy.names = rule_names(baked_, settings_.finds_optimum);
  accuracy.cells.resize(cells_.size());
  progress_stage(progress, "measure");
  if (baked_ != nullptr)
    for (Cell& cell : cells_) cell.baked = baked_->texel(cell.level, cell.x, cell.y);
  const auto measure_one = [&](int, int i, int) {
    accuracy.cells[size_of(i)] = measure(cells_[size_of(i)], inputs, settings);
  };
  for_each_row_band(static_cast<int>(cells_.size()), 1, inputs.threads, progress, measure_one);
  for (const CellAccuracy& cell : accuracy.cells) {
    if (accuracy.levels.empty() || accuracy.levels.back().level != cell.level)
      accuracy.levels.push_back({cell.level, 0.0, std::vector<RuleError>(accuracy.ids.size())});
    LevelAccuracy& level = accuracy.levels.back();
    const auto of_level = [&](const CellAccuracy& one) { return one.level == cell.level; };
    const double share =
        1.0 / static_cast<double>(std::count_if(accuracy.cells.begin(), accuracy.cells.end(), of_level));
    level.noise += cell.noise * cell.noise * share * share;
    for (std::size_t i = 0; i < cell.errors.size(); ++i) {
      add(level.errors[i].point, cell.errors[i].point, share);
      add(level.errors[i].wide, cell.errors[i].wide, share);
    }
  }
  for (LevelAccuracy& level : accuracy.levels) level.noise = std::sqrt(level.noise);
  return accuracy;
}

std::string ExportAccuracy::to_text() const {
  if (levels.empty()) return "";
  std::string text = fmt::format("{:<26}", "error of the highlight, %");
  for (const LevelAccuracy& level : levels)
    text += fmt::format("{:>10}{:>8}", fmt::format("level {}", level.level), "energy");
  text += "\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += fmt::format("{:<26}", names[i]);
    for (const LevelAccuracy& level : levels)
      text += fmt::format("{:>10.0f}{:>8.2f}", 100.0 * level.errors[i].point.error, level.errors[i].point.energy);
    text += "\n";
  }
  return text;
}

std::string ExportAccuracy::to_json() const {
  nlohmann::ordered_json json = {{"lights_per_view", lights_per_view},
                                 {"names", nlohmann::ordered_json::object()},
                                 {"levels", nlohmann::ordered_json::array()},
                                 {"cells", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < ids.size(); ++i) json["names"][ids[i]] = names[i];
  for (const LevelAccuracy& level : levels)
    json["levels"].push_back({{"level", level.level}, {"noise", level.noise}, {"rules", json_of(ids, level.errors)}});
  for (const CellAccuracy& cell : cells)
    json["cells"].push_back({{"level", cell.level},
                             {"x", cell.x},
                             {"y", cell.y},
                             {"noise", cell.noise},
                             {"rules", json_of(ids, cell.errors)}});
  return json.dump();
}

}  // namespace multum
