// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_comparison.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

// Adds |model - reference| and the reference of each point to the sums of the point.
MULTUM_VECTOR_CLONES
void add_differences(const float* __restrict model, const double* __restrict reference, std::size_t count,
                     double* __restrict differences, double* __restrict references) {
  for (std::size_t i = 0; i < count; ++i) {
    differences[i] += std::abs(static_cast<double>(model[i]) - reference[i]);
    references[i] += reference[i];
  }
}

}  // namespace

FootprintSettings footprint_settings(const AccuracySettings& settings) {
  return {settings.footprints_per_octave,
          settings.first_level,
          settings.seed,
          settings.wrap_s,
          settings.wrap_t,
          settings.filter};
}

std::vector<Highlight> highlights_of(const AccuracySettings& settings) {
  std::vector<Highlight> all;
  for (const double s : settings.exponents) all.push_back(blinn_phong_highlight(s));
  all.insert(all.end(), settings.highlights.begin(), settings.highlights.end());
  return all;
}

void append_taps(const SamplePoint& point, const std::vector<std::size_t>& model_slots, PointTaps& taps) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(point.tap_count); ++t)
    taps.add(model_slots[point.slots[t]], point.weights[t]);
  taps.finish_point();
}

AccuracyComparison::AccuracyComparison(const AccuracySettings& settings, const MeasuredPlaces& places,
                                       std::vector<AccuracyModel*> models, bool has_colours)
    : settings_(settings),
      places_(places),
      points_(places.points),
      models_(std::move(models)),
      highlights_(highlights_of(settings)),
      shadings_(models_.front()->shadings()),
      channel_count_(has_colours ? 3 : 0),
      plain_count_(highlights_.size() + 1),
      averages_(points_.texels(), static_cast<int>(points_.texels().sizes().size())),
      sums_(models_.size(), ErrorSums(points_, brdf_count())),
      footprint_sums_(models_.size()) {
  if (has_footprints()) MULTUM_CHECK(settings.directions.half_vector_lights.size() >= half_count());
}

void AccuracyComparison::run(Device& device, const FinestPlanes& planes, Progress* progress) {
  const int first_level = models_.front()->first_level();
  const TexelAverages map_averages(places_.model_texels, first_level);
  PlaneAverages map_lobes(map_averages, channel_count_ > 0);
  std::vector<RowSums*> streamed;
  const std::vector<std::unique_ptr<FootprintReference>> footprint_references = make_footprint_references();
  if (first_level > 0) streamed.push_back(&map_lobes);
  for (AccuracyModel* model : models_) model->set_map_averages(&map_lobes);
  if (points_.samples().empty()) {
    for (const auto& reference : footprint_references) streamed.push_back(reference.get());
    stream_rows(planes, {settings_.threads}, streamed, progress);
  }
  for (std::size_t direction = 0; direction < direction_count() && !points_.samples().empty();) {
    const Pass pass = next_pass(direction);
    for (const auto& reference : pass.references) streamed.push_back(reference.get());
    // This pass also measures the footprints in all directions, and reuses the values that it has evaluated.
    for (std::size_t d = 0; d < footprint_references.size() && direction == 0; ++d)
      if (d < pass.references.size()) pass.references[d]->share_with(*footprint_references[d]);
      else streamed.push_back(footprint_references[d].get());
    stream_rows(planes, {settings_.threads}, streamed, progress);
    streamed.clear();
    compare(device, pass, direction == 0, progress);
    direction += pass.references.size();
  }
  for (std::size_t m = 0; m < models_.size() && has_footprints(); ++m)
    compare_footprints(device, footprint_references, m);
  for (AccuracyModel* model : models_) model->set_map_averages(nullptr);
}

std::vector<AccuracyRow> AccuracyComparison::rows(std::size_t model) const {
  std::vector<AccuracyRow> rows;
  for (int l = 0; l < static_cast<int>(points_.texels().sizes().size()); ++l)
    for (AccuracyPoint kind :
         {AccuracyPoint::kCentre, AccuracyPoint::kMidX, AccuracyPoint::kMidY, AccuracyPoint::kBetween})
      for (std::size_t b = 0; b < brdf_count(); ++b) {
        AccuracyRow made = sums_[model].row(l, kind, b, what_of(b));
        if (made.sample_count > 0) rows.push_back(std::move(made));
      }
  return rows;
}

std::vector<FootprintError> AccuracyComparison::footprint_errors(std::size_t model, int part, int count) const {
  const std::vector<Footprint>& all = places_.footprints.footprints();
  const auto place = [&](int number) {
    return static_cast<std::ptrdiff_t>(all.size()) / count * static_cast<std::ptrdiff_t>(number);
  };
  const std::vector<Footprint> footprints(all.begin() + place(part), all.begin() + place(part + 1));
  std::vector<FootprintError> errors;
  for (std::size_t b = 0; b < footprint_sums_[model].size(); ++b) {
    const std::vector<ErrorSum>& sums = footprint_sums_[model][b];
    errors.push_back(
        footprint_error(what_of(b), footprints, {sums.begin() + place(part), sums.begin() + place(part + 1)}));
  }
  return errors;
}

AccuracyComparison::Pass AccuracyComparison::next_pass(std::size_t first) const {
  constexpr std::size_t kReferenceBytesMax = std::size_t{256} << 20;
  Pass pass{{{}, {}, highlights_, settings_.has_roughness ? settings_.mean_cosine : 0.0f}, {}};
  std::size_t bytes = 0;
  for (std::size_t d = first; d < direction_count(); ++d) {
    const bool is_light = d >= half_count();
    const std::size_t value_count = is_light ? 1 : highlights_.size();
    bytes += averages_.slot_count() * value_count * (1 + channel_count_) * sizeof(double);
    if (!pass.references.empty() && bytes > kReferenceBytesMax) break;
    const glm::dvec3& omega =
        is_light ? settings_.directions.lights[d - half_count()] : settings_.directions.half_vectors[d];
    (is_light ? pass.directions.lights : pass.directions.half_vectors).push_back(omega);
    pass.references.push_back(
        std::make_unique<BrdfReference>(averages_, brdf_values(omega, is_light), channel_count_ > 0));
  }
  return pass;
}

BrdfValues AccuracyComparison::brdf_values(const glm::dvec3& omega, bool is_light) const {
  if (settings_.has_roughness) return shortened_values(omega, is_light);
  return is_light ? power_values(omega, {1.0}) : highlight_values(omega, highlights_);
}

std::vector<std::unique_ptr<FootprintReference>> AccuracyComparison::make_footprint_references() const {
  std::vector<std::unique_ptr<FootprintReference>> references;
  if (!has_footprints()) return references;
  const AccuracyDirections& directions = settings_.directions;
  for (std::size_t d = 0; d < half_count(); ++d) {
    const glm::dvec3& light = directions.lights[static_cast<std::size_t>(directions.half_vector_lights[d])];
    references.push_back(std::make_unique<FootprintReference>(places_.footprints,
                                                              brdf_values(directions.half_vectors[d], false),
                                                              brdf_values(light, true), channel_count_ > 0));
  }
  for (const glm::dvec3& light : directions.lights)
    references.push_back(std::make_unique<FootprintReference>(places_.footprints, std::nullopt,
                                                              brdf_values(light, true), channel_count_ > 0));
  return references;
}

void AccuracyComparison::compare_footprints(Device& device,
                                            const std::vector<std::unique_ptr<FootprintReference>>& references,
                                            std::size_t model) {
  const std::vector<Footprint>& footprints = places_.footprints.footprints();
  const FootprintSettings settings = footprint_settings(settings_);
  PointTaps points;
  std::vector<std::size_t> point_begin = {0};  // [footprint]; the last entry is the end of the last range
  std::vector<FilterTap> taps;
  for (const Footprint& footprint : footprints) {
    taps.clear();
    const int point_count = append_filter_taps(footprint, places_.model_texels.sizes(), settings, taps);
    auto tap = taps.begin();  // taps of a point are adjacent
    for (int p = 0; p < point_count; ++p) {
      for (; tap != taps.end() && tap->point == p; ++tap)
        points.add(places_.model_texels.slot(tap->level, tap->texel), tap->weight);
      points.finish_point();
    }
    point_begin.push_back(points.size());
  }
  const std::unique_ptr<PointShading> shading = models_[model]->make_shading(
      device, {half_count() > 0 ? settings_.directions.half_vectors : std::vector<glm::dvec3>{},
               settings_.directions.lights, highlights_, settings_.has_roughness ? settings_.mean_cosine : 0.0f,
               half_count() > 0 ? settings_.directions.half_vector_lights : std::vector<int>{}});
  footprint_sums_[model].assign(brdf_count(), std::vector<ErrorSum>(footprints.size()));
  std::vector<float> values;
  for (std::size_t way = 0; way < shadings_.size(); ++way)
    for (int channel = -1; channel < static_cast<int>(channel_count_); ++channel) {
      shading->shade(points, static_cast<int>(way), channel, settings_.threads, values);
      const std::size_t first_brdf = (way * groups_per_shading() + (channel < 0 ? 0 : 1)) * plain_count_;
      add_footprints(references, point_begin, values, channel, &footprint_sums_[model][first_brdf]);
    }
}

void AccuracyComparison::add_footprints(const std::vector<std::unique_ptr<FootprintReference>>& references,
                                        const std::vector<std::size_t>& point_begin, const std::vector<float>& values,
                                        int channel, std::vector<ErrorSum>* sums_of) const {
  const std::size_t highlight_count = highlights_.size();
  for (std::size_t d = 0; d < references.size(); ++d) {
    const bool is_light = d >= half_count();
    const std::size_t own_count = is_light ? 1 : highlight_count;
    for (std::size_t e = 0; e < own_count; ++e) {
      const std::size_t value = is_light ? half_count() * highlight_count + d - half_count() : e * half_count() + d;
      std::vector<ErrorSum>& sums = sums_of[is_light ? highlight_count : e];
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const double reference =
            references[d]->at(i, static_cast<std::size_t>(1 + channel) * own_count + e) * value_scale(is_light, e);
        double shaded = 0.0;
        for (std::size_t p = point_begin[i]; p < point_begin[i + 1]; ++p)
          shaded += static_cast<double>(values[value * point_begin.back() + p]);
        shaded /= static_cast<double>(point_begin[i + 1] - point_begin[i]);
        sums[i] += {std::abs(shaded - reference), reference, 1.0};
      }
    }
  }
}

double AccuracyComparison::value_scale(bool is_light, std::size_t highlight) const {
  return is_light || settings_.has_roughness ? 1.0 : highlight_scale(highlights_[highlight]);
}

void AccuracyComparison::compare(Device& device, const Pass& pass, bool is_first, Progress* progress) {
  constexpr std::size_t kSamplesPerBatch = 1 << 12;
  std::vector<std::unique_ptr<PointShading>> shading;
  for (const AccuracyModel* model : models_) shading.push_back(model->make_shading(device, pass.directions));
  const std::size_t sample_count = points_.samples().size();
  std::vector<SamplePoint> points;
  PointTaps taps;
  std::vector<float> values;
  for (std::size_t first = 0; first < sample_count; first += kSamplesPerBatch) {
    progress_advance(progress, 0);  // lets the caller cancel
    points.clear();
    for (std::size_t i = first; i < std::min(first + kSamplesPerBatch, sample_count); ++i)
      points_.append_points(i, points);
    taps.clear();
    for (const SamplePoint& point : points) append_taps(point, places_.model_slots, taps);
    for (int channel = -1; channel < static_cast<int>(channel_count_); ++channel) {
      const std::vector<double> references = references_at(pass, points, channel);
      for (std::size_t m = 0; m < models_.size(); ++m)
        for (std::size_t way = 0; way < shadings_.size(); ++way) {
          shading[m]->shade(taps, static_cast<int>(way), channel, settings_.threads, values);
          const std::size_t first_brdf = (way * groups_per_shading() + (channel < 0 ? 0 : 1)) * plain_count_;
          compare_points(pass, points, values, references, first_brdf, sums_[m]);
        }
    }
    for (std::size_t m = 0; m < models_.size() && is_first; ++m)
      for (const SamplePoint& point : points) sums_[m].count(point);
  }
}

std::vector<double> AccuracyComparison::references_at(const Pass& pass, const std::vector<SamplePoint>& points,
                                                      int channel) const {
  const std::size_t of_highlight = pass.directions.half_vectors.size();
  const std::size_t highlight_values = of_highlight * highlights_.size();
  const std::size_t value_count = highlight_values + pass.directions.lights.size();
  std::vector<double> references(value_count * points.size());
  for_each_item(static_cast<int>(value_count), settings_.threads, [&](int number) {
    const auto value = static_cast<std::size_t>(number);
    const bool is_light = value >= highlight_values;
    const std::size_t highlight = is_light ? 0 : value / of_highlight;
    const std::size_t direction = is_light ? of_highlight + value - highlight_values : value % of_highlight;
    const std::size_t own_value =
        static_cast<std::size_t>(1 + channel) * (is_light ? 1 : highlights_.size()) + highlight;
    const double scale = value_scale(is_light, highlight);
    for (std::size_t i = 0; i < points.size(); ++i)
      references[value * points.size() + i] = reference_at(*pass.references[direction], points[i], own_value) * scale;
  });
  return references;
}

void AccuracyComparison::compare_points(const Pass& pass, const std::vector<SamplePoint>& points,
                                        const std::vector<float>& values, const std::vector<double>& references,
                                        std::size_t first_brdf, ErrorSums& sums) const {
  std::vector<double> differences(points.size()), sums_of_reference(points.size());
  std::size_t value = 0;
  for (std::size_t b = 0; b < plain_count_; ++b) {
    const std::size_t count =
        b < highlights_.size() ? pass.directions.half_vectors.size() : pass.directions.lights.size();
    std::fill(differences.begin(), differences.end(), 0.0);
    std::fill(sums_of_reference.begin(), sums_of_reference.end(), 0.0);
    for (std::size_t end = value + count; value < end; ++value)
      add_differences(values.data() + value * points.size(), references.data() + value * points.size(), points.size(),
                      differences.data(), sums_of_reference.data());
    for (std::size_t i = 0; i < points.size(); ++i)
      sums.add(points[i], first_brdf + b, {differences[i], sums_of_reference[i], static_cast<double>(count)});
  }
}

double AccuracyComparison::reference_at(const TexelSums& reference, const SamplePoint& point, std::size_t value) {
  double sum = 0.0;
  for (std::size_t t = 0; t < static_cast<std::size_t>(point.tap_count); ++t)
    sum += point.weights[t] * reference.at(point.slots[t], value);
  return sum;
}

AccuracyBrdf AccuracyComparison::what_of(std::size_t brdf) const {
  const std::size_t plain = brdf % plain_count_, group = brdf / plain_count_;
  AccuracyBrdf what = plain + 1 == plain_count_ ? AccuracyBrdf::lambert()
                      : settings_.has_roughness ? AccuracyBrdf::roughness()
                                                : highlights_[plain].id;
  what.shading = shadings_[group / groups_per_shading()];
  what.has_colours = group % groups_per_shading() != 0;
  return what;
}

}  // namespace multum
