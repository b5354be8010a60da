// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <utility>

#include "host/bakes/accuracy/accuracy_reference.h"
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

// Adds up the errors of each level, kind of point and BRDF. Each sample represents all texels of its cell. For sampled
// levels, the errors of each point are also kept, because the confidence interval follows from their spread.
//
// The error of a level is R = sum_i w_i d_i / sum_i w_i t_i. For the sample of cell i, d_i is the difference, t_i is
// the reference, and w_i is the number of texels in the cell. Both sums are Horvitz-Thompson estimates (Cochran 1977,
// section 9A.7). With e_i = d_i - R t_i, the variance of R is the variance of sum_i w_i e_i, divided by the squared sum
// of the reference (the delta method, Cochran section 6.4). For a texel without a point of this kind, e_i is 0 (section
// 5A.14).
//
//   v = n / (n - 1) sum_i (1 - 1 / w_i) (w_i e_i - mean)^2
//
// (1 - 1 / w_i) is the finite population correction of a cell. A single sample per cell gives no variance within the
// cell, so the spread among all cells is used instead. The spread among all cells is larger if neighbours are similar
// (section 5A.12).
class ErrorSums {
 public:
  ErrorSums(const AccuracyPoints& points, std::size_t brdf_count)
      : points_(points),
        brdf_count_(brdf_count),
        totals_(points.texels().sizes().size() * kAccuracyPointKinds * brdf_count),
        counts_(points.texels().sizes().size() * kAccuracyPointKinds),
        chosen_(points.chosen_count() * kAccuracyPointKinds * brdf_count) {}

  void count(const SamplePoint& point) {
    const AccuracySample& sample = points_.samples()[point.sample];
    ++counts_[group(sample.level, point.kind)];
  }
  void add(const SamplePoint& point, std::size_t brdf, const ErrorSum& sum) {
    const AccuracySample& sample = points_.samples()[point.sample];
    totals_[group(sample.level, point.kind) * brdf_count_ + brdf] += sum.times(sample.cell_texels);
    if (point.sample < points_.chosen_count()) chosen_[chosen_index(point.sample, point.kind, brdf)] += sum;
  }

  // Returns the ratio of sums and the half width of its 95 % interval.
  AccuracyRow row(int level, AccuracyPoint kind, std::size_t brdf, AccuracyBrdf what) const {
    AccuracyRow row{level, kind, std::move(what), 0.0, 0.0, counts_[group(level, kind)]};
    const ErrorSum& total = totals_[group(level, kind) * brdf_count_ + brdf];
    if (!(total.count > 0.0)) return row;
    const ErrorBase base(total);
    row.error = total.difference / base.of(total);
    if (!is_sampled(level)) return row;
    const double variance = total_variance(level, [&](std::size_t sample) {
      const ErrorSum& sum = chosen_[chosen_index(sample, kind, brdf)];
      return sum.difference - row.error * base.of(sum);
    });
    row.confidence = std::max(kIntervalMin, 1.96 * std::sqrt(variance) / base.of(total));
    return row;
  }

 private:
  bool is_sampled(int level) const {
    return points_.chosen_count() > 0 && level <= points_.samples()[points_.chosen_count() - 1].level;
  }

  // Returns the variance v (see above) of the sum of residual(sample) over all texels of a sampled level.
  template <typename Residual>
  double total_variance(int level, const Residual& residual) const {
    double sum = 0.0, n = 0.0;
    const auto for_each_sample = [&](const auto& body) {
      for (std::size_t i = 0; i < points_.chosen_count(); ++i) {
        const AccuracySample& sample = points_.samples()[i];
        if (sample.level == level) body(static_cast<double>(sample.cell_texels), residual(i));
      }
    };
    for_each_sample([&](double weight, double value) {
      sum += weight * value;
      n += 1.0;
    });
    double squares = 0.0;
    for_each_sample([&](double weight, double value) {
      const double off = weight * value - sum / n;
      squares += (1.0 - 1.0 / weight) * off * off;
    });
    return squares * n / (n - 1.0);  // AccuracyPoints takes at least two samples per sampled level
  }

  std::size_t group(int level, AccuracyPoint kind) const {
    return static_cast<std::size_t>(level) * kAccuracyPointKinds + static_cast<std::size_t>(kind);
  }
  std::size_t chosen_index(std::size_t sample, AccuracyPoint kind, std::size_t brdf) const {
    return (sample * kAccuracyPointKinds + static_cast<std::size_t>(kind)) * brdf_count_ + brdf;
  }

  const AccuracyPoints& points_;
  std::size_t brdf_count_;
  std::vector<ErrorSum> totals_;      // [level][kind][brdf]
  std::vector<std::int64_t> counts_;  // [level][kind]
  std::vector<ErrorSum> chosen_;      // [sample][kind][brdf]
};

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

// The texels and footprints that a measurement reads.
struct MeasuredPlaces {
  const AccuracyPoints& points;
  const FootprintAverages& footprints;
  const TexelSelection& model_texels;
  const std::vector<std::size_t>& model_slots;  // the slots of the texels that points read
};

void append_taps(const SamplePoint& point, const std::vector<std::size_t>& model_slots, PointTaps& taps) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(point.tap_count); ++t)
    taps.add(model_slots[point.slots[t]], point.weights[t]);
  taps.finish_point();
}

// One measurement of one or several models of the same kind. Each pass evaluates the reference for as many directions
// as fit into memory, and compares the reference with the models. There are few footprints, so the first pass handles
// all of them.
class Comparison {
 public:
  Comparison(const AccuracySettings& settings, const MeasuredPlaces& places, std::vector<AccuracyModel*> models,
             bool has_colours)
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

  void run(Device& device, const FinestPlanes& planes, Progress* progress) {
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

  std::vector<AccuracyRow> rows(std::size_t model) const {
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

  // Measures one part of the footprints, which are split into `count` equal, consecutive parts.
  std::vector<FootprintError> footprint_errors(std::size_t model, int part, int count) const {
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

 private:
  // `directions` and `references` hold half vectors first, then lights.
  struct Pass {
    ShadingDirections directions;
    std::vector<std::unique_ptr<BrdfReference>> references;
  };

  bool has_footprints() const { return !places_.footprints.footprints().empty(); }
  std::size_t direction_count() const { return half_count() + settings_.directions.lights.size(); }
  std::size_t half_count() const { return highlights_.empty() ? 0 : settings_.directions.half_vectors.size(); }

  // If the values of all directions do not fit into memory, another pass over the map is made. With 2048 samples per
  // level, the 40 values of all directions need 33 MB for a map of 16384 x 16384 texels, or four times as much with
  // colours. If every texel of a map of 1024 x 1024 texels is measured, three values need 34 MB. The result does not
  // depend on the number of threads, because sums are added pass by pass.
  Pass next_pass(std::size_t first) const {
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

  BrdfValues brdf_values(const glm::dvec3& omega, bool is_light) const {
    if (settings_.has_roughness) return shortened_values(omega, is_light);
    return is_light ? power_values(omega, {1.0}) : highlight_values(omega, highlights_);
  }

  // References for half vectors first, then for lights.
  std::vector<std::unique_ptr<FootprintReference>> make_footprint_references() const {
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

  // Fills footprint_sums_[model][BRDF][footprint].
  void compare_footprints(Device& device, const std::vector<std::unique_ptr<FootprintReference>>& references,
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

  // Adds the errors of one colour channel to sums_of[highlights, then Lambert]. The channel is -1 if there are no
  // colours.
  void add_footprints(const std::vector<std::unique_ptr<FootprintReference>>& references,
                      const std::vector<std::size_t>& point_begin, const std::vector<float>& values, int channel,
                      std::vector<ErrorSum>* sums_of) const {
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

  // Returns the factor by which the averages of the reference must still be multiplied.
  double value_scale(bool is_light, std::size_t highlight) const {
    return is_light || settings_.has_roughness ? 1.0 : highlight_scale(highlights_[highlight]);
  }

  void compare(Device& device, const Pass& pass, bool is_first, Progress* progress) {
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

  // Returns the reference of each point for one colour channel, [value][point], in the order of the model's values. The
  // channel is -1 if there are no colours.
  std::vector<double> references_at(const Pass& pass, const std::vector<SamplePoint>& points, int channel) const {
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

  // Adds the differences of points to BRDFs first_brdf + (highlights, then Lambert).
  void compare_points(const Pass& pass, const std::vector<SamplePoint>& points, const std::vector<float>& values,
                      const std::vector<double>& references, std::size_t first_brdf, ErrorSums& sums) const {
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

  static double reference_at(const TexelSums& reference, const SamplePoint& point, std::size_t value) {
    double sum = 0.0;
    for (std::size_t t = 0; t < static_cast<std::size_t>(point.tap_count); ++t)
      sum += point.weights[t] * reference.at(point.slots[t], value);
    return sum;
  }

  // There is one group without colours and, if the file has colours, one group with colours.
  std::size_t groups_per_shading() const { return channel_count_ > 0 ? 2 : 1; }
  std::size_t brdf_count() const { return plain_count_ * groups_per_shading() * shadings_.size(); }
  AccuracyBrdf what_of(std::size_t brdf) const {
    const std::size_t plain = brdf % plain_count_, group = brdf / plain_count_;
    AccuracyBrdf what = plain + 1 == plain_count_ ? AccuracyBrdf::lambert()
                        : settings_.has_roughness ? AccuracyBrdf::roughness()
                                                  : highlights_[plain].id;
    what.shading = shadings_[group / groups_per_shading()];
    what.has_colours = group % groups_per_shading() != 0;
    return what;
  }

  const AccuracySettings& settings_;
  const MeasuredPlaces places_;
  const AccuracyPoints& points_;
  const std::vector<AccuracyModel*> models_;
  const std::vector<Highlight> highlights_;
  const std::vector<std::string> shadings_;
  const std::size_t channel_count_;  // 0 if there are no colours
  const std::size_t plain_count_;    // number of BRDFs: highlights, then Lambert
  const TexelAverages averages_;
  std::vector<ErrorSums> sums_;                                     // [model]
  std::vector<std::vector<std::vector<ErrorSum>>> footprint_sums_;  // [model][BRDF][footprint]
};

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
  Comparison comparison(settings_, {points_, footprints_, texels_, model_slots_}, {&model()}, albedo != nullptr);
  comparison.run(device, {normals, albedo}, progress);
  footprint_errors_ = comparison.footprint_errors(0, 0, 1);
  replicate_errors_.clear();
  for (int r = 0; r < settings_.replicates; ++r)
    replicate_errors_.push_back(comparison.footprint_errors(0, r, settings_.replicates));
  return comparison.rows(0);
}

std::vector<std::vector<AccuracyRow>> AccuracyMeter::measure_levels(Device& device, const PlaneStore& normals,
                                                                    const std::vector<AccuracyModel*>& models) const {
  Comparison comparison(settings_, {points_, footprints_, texels_, model_slots_}, models, false);
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
