// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>

#include "host/bakes/accuracy/accuracy_comparison.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

std::vector<PlaneSize> level_sizes(int map_width, int map_height) {
  std::vector<PlaneSize> sizes;
  for (int l = 0; l < mip_level_count(map_width, map_height); ++l)
    sizes.push_back({mip_level_size(map_width, l), mip_level_size(map_height, l)});
  return sizes;
}

}  // namespace

std::string error_text(double error, double confidence) {
  return fmt::format("{:.2f} +- {:.2f} %", 100.0 * error, 100.0 * confidence);
}

AccuracyDirections accuracy_directions() {
  AccuracyDirections directions;
  for (const glm::dvec3& light :
       {glm::dvec3(.3, .2, .93), glm::dvec3(-.7, .1, .7), glm::dvec3(.1, -.9, .45), glm::dvec3(.5, .6, .6)})
    directions.lights.push_back(glm::normalize(light));
  for (std::size_t i = 0; i < directions.lights.size(); ++i)
    for (const glm::dvec3& view : {glm::dvec3(0, 0, 1), glm::dvec3(.6, 0, .8), glm::dvec3(-.3, .7, .6)}) {
      directions.half_vectors.push_back(glm::normalize(directions.lights[i] + glm::normalize(view)));
      directions.half_vector_lights.push_back(static_cast<int>(i));
    }
  return directions;
}

namespace {

AccuracySettings of_file(AccuracySettings settings, const BakedHeader& header) {
  settings.has_roughness = header.has_roughness;
  settings.mean_cosine = header.mean_cosine;
  settings.wrap_s = header.wrap_s;
  settings.wrap_t = header.wrap_t;
  if (header.has_roughness) {
    settings.exponents = {static_cast<double>(kRoughnessExponent)};
    settings.highlights.clear();
  }
  return settings;
}

// Returns the number of samples per level. Smaller maps have fewer, so that measuring them is faster than baking them.
std::int64_t samples_in(PlaneSize map, std::int64_t of_large_map) {
  constexpr double kLargeSide = 4096.0;
  constexpr std::int64_t kSamplesMin = 512;
  const double side = std::sqrt(static_cast<double>(map.width) * map.height);
  const auto samples = std::llround(static_cast<double>(of_large_map) * std::min(side / kLargeSide, 1.0));
  return std::max<std::int64_t>(samples, std::min(kSamplesMin, of_large_map));
}

SampleSettings sample_settings(const AccuracySettings& settings, PlaneSize map) {
  const int none = mip_level_count(map.width, map.height);
  return {settings.has_level_table ? settings.first_level : none, samples_in(map, settings.samples_per_level),
          settings.seed};
}

std::vector<Footprint> footprints_of(PlaneSize map, const AccuracySettings& settings) {
  MULTUM_CHECK(settings.replicates >= 1);
  FootprintSettings own = footprint_settings(settings);
  std::vector<Footprint> all;
  for (int r = 0; r < settings.replicates; ++r, ++own.seed) {
    const std::vector<Footprint> chosen = choose_footprints(map.width, map.height, own);
    all.insert(all.end(), chosen.begin(), chosen.end());
  }
  return all;
}

TexelSelection model_texels(const AccuracyPoints& points, const FootprintAverages& footprints,
                            const AccuracySettings& settings) {
  const std::vector<PlaneSize>& sizes = points.texels().sizes();
  std::vector<std::vector<int>> texels(sizes.size());
  std::vector<FilterTap> taps;
  for (const Footprint& footprint : footprints.footprints())
    append_filter_taps(footprint, sizes, footprint_settings(settings), taps);
  for (const FilterTap& tap : taps) texels[static_cast<std::size_t>(tap.level)].push_back(tap.texel);
  for (std::size_t level = 0; level < sizes.size(); ++level)
    for (int y = 0; y < sizes[level].height; ++y) {
      const int l = static_cast<int>(level);
      for (std::size_t slot = points.texels().row_begin(l, y); slot < points.texels().row_end(l, y); ++slot)
        texels[level].push_back(y * sizes[level].width + points.texels().column(slot));
    }
  return {sizes, std::move(texels)};
}

std::vector<std::size_t> slots_in(const TexelSelection& all, const TexelSelection& some) {
  std::vector<std::size_t> slots;
  for (int l = 0; l < static_cast<int>(some.sizes().size()); ++l) {
    const PlaneSize size = some.sizes()[static_cast<std::size_t>(l)];
    for (int y = 0; y < size.height; ++y)
      for (std::size_t slot = some.row_begin(l, y); slot < some.row_end(l, y); ++slot)
        slots.push_back(all.slot(l, y * size.width + some.column(slot)));
  }
  return slots;
}

}  // namespace

AccuracyMeter::AccuracyMeter(PlaneSize map, const BakedHeader& header, const AccuracySettings& settings)
    : settings_(of_file(settings, header)),
      points_(level_sizes(map.width, map.height), sample_settings(settings_, map)),
      footprints_(footprints_of(map, settings_), map.width, map.height, footprint_settings(settings_)),
      texels_(model_texels(points_, footprints_, settings_)),
      model_slots_(slots_in(texels_, points_.texels())) {}

bool AccuracyMeter::needs_rows(int level, int first_row, int row_count) const {
  return texels_.row_begin(level, first_row) < texels_.row_begin(level, first_row + row_count);
}

std::vector<AccuracyRow> AccuracyMeter::run(Device& device, const PlaneStore& normals, const PlaneStore* albedo,
                                            Progress* progress) {
  const PlaneSize size = texels_.sizes().front();
  MULTUM_CHECK(normals.width() == size.width && normals.height() == size.height);
  MULTUM_CHECK(albedo == nullptr || model().has_colours());
  AccuracyComparison comparison(settings_, {points_, footprints_, texels_, model_slots_}, {&model()},
                                albedo != nullptr);
  comparison.run(device, {normals, albedo}, progress);
  footprint_errors_ = comparison.footprint_errors(0, 0, 1);
  replicate_errors_.clear();
  for (int r = 0; r < settings_.replicates; ++r)
    replicate_errors_.push_back(comparison.footprint_errors(0, r, settings_.replicates));
  return comparison.rows(0);
}

std::vector<std::vector<AccuracyRow>> AccuracyMeter::measure_levels(Device& device, const PlaneStore& normals,
                                                                    const std::vector<AccuracyModel*>& models) const {
  AccuracyComparison comparison(settings_, {points_, footprints_, texels_, model_slots_}, models, false);
  comparison.run(device, {normals, nullptr}, nullptr);
  std::vector<std::vector<AccuracyRow>> rows;
  for (std::size_t m = 0; m < models.size(); ++m) rows.push_back(comparison.rows(m));
  return rows;
}

std::vector<LevelDifference> AccuracyMeter::difference_from(AccuracyMeter& by_default, Device& device,
                                                            const PlaneStore& normals, const PlaneStore* albedo,
                                                            Progress* progress) {
  const int level_count = static_cast<int>(points_.texels().sizes().size());
  MULTUM_CHECK(model().first_level() == by_default.model().first_level());
  MULTUM_CHECK(texels_.slot_count() == by_default.texels_.slot_count());
  const TexelAverages finest(texels_, model().first_level()), all(points_.texels(), level_count);
  PlaneAverages finest_lobes(finest, albedo != nullptr), means(all, albedo != nullptr);
  stream_rows({normals, albedo}, {settings_.threads}, {&finest_lobes, &means}, progress);
  const std::vector<Highlight> highlights = highlights_of(settings_);
  const ShadingDirections directions{highlights.empty() ? std::vector<glm::dvec3>{} : settings_.directions.half_vectors,
                                     settings_.directions.lights, highlights,
                                     settings_.has_roughness ? settings_.mean_cosine : 0.0f};
  const std::size_t half_count = directions.half_vectors.size(), light_count = directions.lights.size();
  const std::size_t highlight_count = highlights.size();
  const std::size_t value_count = half_count * highlight_count + light_count;
  std::vector<SamplePoint> points;
  for (std::size_t i = 0; i < points_.samples().size(); ++i) points_.append_points(i, points);
  PointTaps taps;
  for (const SamplePoint& point : points) append_taps(point, model_slots_, taps);

  const auto index = [&](int level, std::size_t brdf) {
    return static_cast<std::size_t>(level) * (highlight_count + 1) + brdf;
  };
  std::vector<LevelDifference> sums;
  for (int l = 0; l < level_count; ++l) {
    for (const Highlight& highlight : highlights)
      sums.push_back({l, settings_.has_roughness ? AccuracyBrdf::roughness() : highlight.id});
    sums.push_back({l, AccuracyBrdf::lambert()});
  }
  // Values [point][highlight, half vector; then light] of one channel. The channel is -1 if there are no colours.
  const auto shaded = [&](AccuracyMeter& meter, int channel) {
    AccuracyModel& shown = meter.model();
    shown.set_map_averages(&finest_lobes);
    const bool takes_mean = channel >= 0 && !shown.has_colours();
    const std::unique_ptr<PointShading> shading = shown.make_shading(device, directions);
    std::vector<float> values;
    // If there are several shading methods, the last one is the runtime's default.
    shading->shade(taps, static_cast<int>(shown.shadings().size()) - 1, takes_mean ? -1 : channel, settings_.threads,
                   values);
    for (std::size_t i = 0; takes_mean && i < points.size(); ++i) {
      double colour = 0.0;
      for (std::size_t t = 0; t < static_cast<std::size_t>(points[i].tap_count); ++t)
        colour += points[i].weights[t] * means.at(points[i].slots[t], static_cast<std::size_t>(3 + channel));
      for (std::size_t v = 0; v < value_count; ++v) values[v * points.size() + i] *= static_cast<float>(colour);
    }
    shown.set_map_averages(nullptr);
    return values;
  };
  for (int channel = -1; channel < (albedo != nullptr ? 3 : 0); ++channel) {
    const std::vector<float> own = shaded(*this, channel), other = shaded(by_default, channel);
    const bool takes_lights = (channel >= 0) == (albedo != nullptr);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t v = 0; v < value_count; ++v) {
        const bool is_light = v >= half_count * highlight_count;
        if (is_light ? !takes_lights : channel >= 0) continue;
        LevelDifference& sum =
            sums[index(points_.samples()[points[i].sample].level, is_light ? highlight_count : v / half_count)];
        const double weight = points_.samples()[points[i].sample].cell_texels;
        const auto a = static_cast<double>(own[v * points.size() + i]),
                   b = static_cast<double>(other[v * points.size() + i]);
        sum.difference += weight * std::abs(a - b);
        sum.by_default += weight * b;
      }
  }
  return sums;
}

namespace {

std::vector<AccuracyRow> run_on_maps(Device& device, AccuracyMeter& meter, const NormalMap& map,
                                     const ColourMap* albedo, Progress* progress) {
  const PlaneStore normals = planes_of(map);
  if (albedo == nullptr) return meter.run(device, normals, nullptr, progress);
  const PlaneStore colours = planes_of(*albedo);
  return meter.run(device, normals, &colours, progress);
}

}  // namespace

std::vector<AccuracyRow> measure_accuracy(Device& device, const MovmfMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress) {
  MovmfMeter meter(mipmap, albedo != nullptr, settings);
  for (int l = mipmap.header.first_level; l < static_cast<int>(mipmap.levels.size()); ++l)
    meter.add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
  return run_on_maps(device, meter, map, albedo, progress);
}

namespace {

// Measures several mipmaps of lobes at the same texels.
class LobesMeter : public AccuracyMeter {
 public:
  LobesMeter(const std::vector<MovmfMipmap>& mipmaps, const AccuracySettings& settings)
      : AccuracyMeter({mipmaps.front().width(), mipmaps.front().height()}, mipmaps.front().header, settings) {
    for (const MovmfMipmap& mipmap : mipmaps) {
      MovmfModel& model = *models_.emplace_back(std::make_unique<MovmfModel>(mipmap, false, texels()));
      for (int l = mipmap.header.first_level; l < static_cast<int>(mipmap.levels.size()); ++l)
        model.add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
    }
  }

  std::vector<std::vector<AccuracyRow>> run(Device& device, const PlaneStore& normals) const {
    std::vector<AccuracyModel*> models;
    for (const auto& model : models_) models.push_back(model.get());
    return measure_levels(device, normals, models);
  }

 private:
  AccuracyModel& model() override { return *models_.front(); }
  std::vector<std::unique_ptr<MovmfModel>> models_;
};

}  // namespace

std::vector<std::vector<AccuracyRow>> measure_each(Device& device, const std::vector<MovmfMipmap>& mipmaps,
                                                   const PlaneStore& normals, const AccuracySettings& settings) {
  return LobesMeter(mipmaps, settings).run(device, normals);
}

namespace {

// `levels` holds rows in the form that add_rows() of the meter accepts.
template <typename Meter, typename Level>
void add_levels(Meter& meter, const BakedHeader& header, const std::vector<Level>& levels) {
  for (int l = header.first_level; l < header.level_count(); ++l)
    meter.add_rows(l, 0, levels[static_cast<std::size_t>(l)]);
}

}  // namespace

std::vector<AccuracyRow> measure_accuracy(Device& device, const MomentMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress) {
  MomentMeter meter(mipmap.header, settings);
  add_levels(meter, mipmap.header, mipmap.levels);
  return run_on_maps(device, meter, map, albedo, progress);
}

std::vector<AccuracyRow> measure_accuracy(Device& device, const ShMipmap& mipmap, const NormalMap& map,
                                          const ColourMap* albedo, const AccuracySettings& settings,
                                          Progress* progress) {
  ShMeter meter(mipmap, settings);
  add_levels(meter, mipmap.header, mipmap.levels);
  return run_on_maps(device, meter, map, albedo, progress);
}

}  // namespace multum
