// SPDX-License-Identifier: Apache-2.0
#include "host/bake/movmf_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "host/bake/mip_schedule.h"
#include "host/bake/movmf_em_step.h"
#include "host/bake/movmf_start.h"
#include "host/base/error.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

constexpr int kLevelZeroTexels = 1 << 20;  // texels of a level-0 band

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::size_t texel_count(int width, int height) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

class MovmfFitter {
 public:
  MovmfFitter(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
              const MovmfFitPlan& plan, BakeReport& report, Progress* progress)
      : device_(device),
        map_(map),
        albedo_(albedo),
        settings_(settings),
        report_(report),
        progress_(progress),
        schedule_(make_mip_schedule(map.width, map.height, settings, plan.weighted)),
        top_start_(plan.top_start),
        em_step_(device, map, albedo, settings, schedule_),
        level_zero_kernel_(device.kernel("movmf_level_zero", "movmf_level_zero",
                                         KernelVariant{settings.lobe_count, 1, schedule_.weighted})) {
    const int level_count = mip_level_count(map.width, map.height);
    lobes_.resize(static_cast<std::size_t>(level_count));
    result_.levels.resize(static_cast<std::size_t>(level_count));
    report_.levels.resize(static_cast<std::size_t>(level_count));
    for (int l = 0; l < level_count; ++l) {
      MovmfLevel& level = result_.levels[static_cast<std::size_t>(l)];
      level.width = mip_level_size(map.width, l);
      level.height = mip_level_size(map.height, l);
      level.lobes.resize(lobe_count());
      if (albedo_ != nullptr) level.colours.resize(lobe_count());
    }
    result_.first_level = settings.first_level;
  }

  MovmfMipmap run() {
    for (const LevelSchedule& level : schedule_.levels) fit_level(level);
    if (settings_.first_level == 0) fit_level_zero();
    report_.levels.erase(report_.levels.begin(), report_.levels.begin() + settings_.first_level);
    return std::move(result_);
  }

 private:
  std::size_t lobe_count() const { return static_cast<std::size_t>(settings_.lobe_count); }

  void fit_level(const LevelSchedule& level) {
    progress_stage(progress_, fmt::format("fit level {}", level.level));
    const double start_seconds = now_seconds();
    const std::uint64_t launches_before = device_.launch_total();
    const std::size_t texels = texel_count(level.fit.width, level.fit.height);
    DeviceBuffer& lobes = lobes_[static_cast<std::size_t>(level.level)];
    lobes = device_.make_buffer(lobe_count() * texels * sizeof(MultumVmfLobe), "the lobes of a level");
    DeviceBuffer colours;
    if (albedo_ != nullptr)
      colours = device_.make_buffer(lobe_count() * texels * 3 * sizeof(float), "the colours of a level");
    MultumMovmfFit fit = level.fit;
    if (fit.parent_width == 0 || !settings_.aligned_start) {
      write_parentless_start(level, lobes);
      fit.parent_width = fit.parent_height = 0;
    }
    em_step_.begin_level(level);
    const int sweeps = fit.parent_width > 0 ? settings_.sweep_count : 1;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      if (sweep > 0) {
        fit.order = MULTUM_ORDER_AGAIN;
        fit.iteration_count = level.iteration_count_again;
      }
      fit_sweep(level, fit, lobes, sweep + 1 == sweeps ? colours : DeviceBuffer());
      progress_advance(progress_, texel_count(map_.width, map_.height) / static_cast<unsigned>(sweeps));
    }
    read_level(level, lobes, colours);
    report_.levels[static_cast<std::size_t>(level.level)] = {level.level, level.fit.width, level.fit.height,
                                                             now_seconds() - start_seconds,
                                                             device_.launch_total() - launches_before};
  }

  // Every step of a level once. An empty `colours` buffer: none are wanted.
  void fit_sweep(const LevelSchedule& level, const MultumMovmfFit& fit, DeviceBuffer& lobes, DeviceBuffer colours) {
    // A start without a parent reads its own texel's lobes; the parent argument is then only a placeholder.
    const std::size_t parent_level = std::min(static_cast<std::size_t>(level.level) + 1, lobes_.size() - 1);
    const DeviceBuffer& parent = fit.parent_width > 0 ? lobes_[parent_level] : lobes;
    for (const FitStep& step : level.steps) em_step_.run(level.method, fit, step, parent, lobes, colours, progress_);
  }

  // Texels without a parent: the coarsest level, and every level of an unaligned bake.
  void write_parentless_start(const LevelSchedule& level, DeviceBuffer& lobes) {
    const MultumMovmfFit& fit = level.fit;
    const std::size_t texels = texel_count(fit.width, fit.height);
    std::vector<MultumVmfLobe> start(lobe_count() * texels);
    for (int y = 0; y < fit.height; ++y)
      for (int x = 0; x < fit.width; ++x) {
        const std::vector<MultumVmfLobe> chosen = parentless_start(level, x, y);
        for (std::size_t j = 0; j < lobe_count(); ++j)
          start[j * texels + static_cast<std::size_t>(y * fit.width + x)] = chosen[j];
      }
    device_.write(lobes, start.data(), start.size() * sizeof(MultumVmfLobe));
  }

  std::vector<MultumVmfLobe> parentless_start(const LevelSchedule& level, int x, int y) const {
    if (level.fit.parent_width == 0) return top_start_;
    const auto edge = [](std::int64_t texel, int map_size, int size) {
      return static_cast<int>(texel * map_size / size);
    };
    const int x0 = edge(x, map_.width, level.fit.width), y0 = edge(y, map_.height, level.fit.height);
    const TexelRectangle covered = {x0, y0, std::max(x0 + 1, edge(x + 1, map_.width, level.fit.width)),
                                    std::max(y0 + 1, edge(y + 1, map_.height, level.fit.height))};
    return farthest_first_lobes(map_, covered, settings_.lobe_count);
  }

  void read_level(const LevelSchedule& level, const DeviceBuffer& lobes, const DeviceBuffer& colours) {
    const std::size_t texels = texel_count(level.fit.width, level.fit.height);
    std::vector<MultumVmfLobe> fitted(lobe_count() * texels);
    device_.read(lobes, fitted.data(), fitted.size() * sizeof(MultumVmfLobe));
    MovmfLevel& out = result_.levels[static_cast<std::size_t>(level.level)];
    for (std::size_t j = 0; j < lobe_count(); ++j) store_lobes(out, j, fitted.data() + j * texels, texels, 0);
    count_events(fitted);
    if (albedo_ != nullptr) {
      std::vector<glm::vec3> fitted_colours(lobe_count() * texels);
      device_.read(colours, fitted_colours.data(), fitted_colours.size() * sizeof(glm::vec3));
      for (std::size_t j = 0; j < lobe_count(); ++j)
        out.colours[j].assign(fitted_colours.begin() + static_cast<std::ptrdiff_t>(j * texels),
                              fitted_colours.begin() + static_cast<std::ptrdiff_t>((j + 1) * texels));
    }
    for (std::size_t i = 0; i < texels; ++i) make_shares_sum_to_one(out, i);
  }

  // A share is a sum of many single-precision responsibilities: those of a texel sum to 1 within 7e-6 on a 2048 map.
  // The other channels carry the same factor, and are divided by it too.
  static void make_shares_sum_to_one(MovmfLevel& level, std::size_t texel) {
    double sum = 0.0;
    for (const auto& lobe : level.lobes) sum += static_cast<double>(lobe[texel].w);
    if (!(sum > 0.0)) return;
    const auto factor = static_cast<float>(1.0 / sum);
    for (auto& lobe : level.lobes) lobe[texel] *= factor;
    for (auto& colour : level.colours) colour[texel] *= factor;
  }

  static void store_lobes(MovmfLevel& out, std::size_t lobe, const MultumVmfLobe* from, std::size_t count,
                          std::size_t offset) {
    std::vector<glm::vec4>& to = out.lobes[lobe];
    to.resize(texel_count(out.width, out.height));
    for (std::size_t i = 0; i < count; ++i) {
      const float a = from[i].amplitude;
      to[offset + i] = {a * from[i].mean_x, a * from[i].mean_y, a * from[i].mean_z, a};
    }
  }

  void count_events(const std::vector<MultumVmfLobe>& lobes) {
    for (const MultumVmfLobe& lobe : lobes) {
      const float squared = lobe.mean_x * lobe.mean_x + lobe.mean_y * lobe.mean_y + lobe.mean_z * lobe.mean_z;
      if (!std::isfinite(squared) || !std::isfinite(lobe.amplitude)) ++report_.nonfinite;
      else if (lobe.amplitude < 1e-6f) ++report_.dead_lobes;
      else if (squared < 1e-6f) ++report_.undirected_lobes;
      else if (1.0f - std::sqrt(squared) < 1.0f / settings_.kappa_cap) ++report_.kappa_clamped;
    }
    report_.lobe_count_total += lobes.size();
  }

  void fit_level_zero() {
    progress_stage(progress_, "fit level 0");
    const double start_seconds = now_seconds();
    const std::uint64_t launches_before = device_.launch_total();
    MovmfLevel& out = result_.levels[0];
    const bool has_parent = result_.levels.size() > 1 && settings_.aligned_start;
    const int parent_width = has_parent ? result_.levels[1].width : 0;
    const int parent_height = has_parent ? result_.levels[1].height : 0;
    const int band_rows = std::clamp(kLevelZeroTexels / map_.width, 1, map_.height);
    DeviceBuffer band = device_.make_buffer(lobe_count() * texel_count(map_.width, band_rows) * sizeof(MultumVmfLobe),
                                            "a band of level 0");
    const DeviceBuffer& parent = has_parent ? lobes_[1] : band;
    std::vector<MultumVmfLobe> fitted(lobe_count() * texel_count(map_.width, band_rows));
    for (int first_row = 0; first_row < map_.height; first_row += band_rows) {
      const int rows = std::min(band_rows, map_.height - first_row);
      const std::size_t texels = texel_count(map_.width, rows);
      level_zero_kernel_.launch({texels}, em_step_.normals().buffer[0], em_step_.normals().buffer[1],
                                em_step_.normals().buffer[2], parent, band, map_.width, parent_width, parent_height,
                                first_row, rows);
      device_.read(band, fitted.data(), lobe_count() * texels * sizeof(MultumVmfLobe));
      const std::size_t offset = texel_count(map_.width, first_row);
      for (std::size_t j = 0; j < lobe_count(); ++j) store_lobes(out, j, fitted.data() + j * texels, texels, offset);
      progress_advance(progress_, texels);
    }
    for (std::size_t j = 0; albedo_ != nullptr && j < lobe_count(); ++j) {
      out.colours[j].resize(texel_count(map_.width, map_.height));
      for (std::size_t i = 0; i < out.colours[j].size(); ++i)
        out.colours[j][i] = out.lobes[j][i].w * glm::vec3(albedo_->r[i], albedo_->g[i], albedo_->b[i]);
    }
    report_.lobe_count_total += lobe_count() * texel_count(map_.width, map_.height);
    report_.levels[0] = {0, map_.width, map_.height, now_seconds() - start_seconds,
                         device_.launch_total() - launches_before};
  }

  Device& device_;
  const NormalMap& map_;
  const ColourMap* albedo_;
  const MovmfSettings settings_;
  BakeReport& report_;
  Progress* progress_;
  const MipSchedule schedule_;
  const std::vector<MultumVmfLobe> top_start_;
  MovmfEmStep em_step_;
  Kernel level_zero_kernel_;
  std::vector<DeviceBuffer> lobes_;  // by level; [0] unused: level 0 is made in bands
  MovmfMipmap result_;
};

}  // namespace

MovmfMipmap fit_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                      const MovmfFitPlan& plan, BakeReport& report, Progress* progress) {
  return MovmfFitter(device, map, albedo, settings, plan, report, progress).run();
}

}  // namespace multum
