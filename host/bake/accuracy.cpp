// SPDX-License-Identifier: Apache-2.0
#include "host/bake/accuracy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "host/bake/mip_coverage.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/base/split_mix.h"

namespace multum {
namespace {

using Plane = std::vector<double>;

// A point of the pyramid as weighted texels: one for a centre, two midway, up to five between levels.
struct Tap {
  int level;
  int texel;
  double weight;
};
struct SamplePoint {
  AccuracyPoint kind;
  int level;
  std::array<Tap, 5> taps;
  int tap_count;
};

// One texel at random in each cell of a regular grid: spread evenly, no two alike. All texels when they are few enough.
std::vector<int> sampled_texels(int width, int height, std::int64_t wanted, SplitMix64& random) {
  const std::int64_t count = std::int64_t{width} * height;
  std::vector<int> texels;
  const int stride =
      wanted <= 0 || count <= wanted
          ? 1
          : static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count) / static_cast<double>(wanted))));
  for (int y = 0; y < height; y += stride)
    for (int x = 0; x < width; x += stride) {
      const int cell_width = std::min(stride, width - x), cell_height = std::min(stride, height - y);
      const int dx = static_cast<int>(random.next() % static_cast<unsigned>(cell_width));
      const int dy = static_cast<int>(random.next() % static_cast<unsigned>(cell_height));
      texels.push_back((y + dy) * width + x + dx);
    }
  return texels;
}

// The four texels of `size` around the point that is the centre of texel i of `fine_size`, along one axis, clamped.
struct AxisTaps {
  int first, second;
  double second_weight;
};
AxisTaps bilinear_axis(int i, int fine_size, int size) {
  const double position = (i + 0.5) / fine_size * size - 0.5;
  const int low = static_cast<int>(std::floor(position));
  return {std::clamp(low, 0, size - 1), std::clamp(low + 1, 0, size - 1), position - low};
}

SamplePoint between_point(const MovmfMipmap& mipmap, int level, int x, int y) {
  const MovmfLevel& fine = mipmap.levels[static_cast<std::size_t>(level)];
  const MovmfLevel& coarse = mipmap.levels[static_cast<std::size_t>(level) + 1];
  const AxisTaps h = bilinear_axis(x, fine.width, coarse.width), v = bilinear_axis(y, fine.height, coarse.height);
  SamplePoint point{AccuracyPoint::kBetween, level, {}, 5};
  point.taps[0] = {level, y * fine.width + x, 0.5};
  point.taps[1] = {level + 1, v.first * coarse.width + h.first, 0.5 * (1 - h.second_weight) * (1 - v.second_weight)};
  point.taps[2] = {level + 1, v.first * coarse.width + h.second, 0.5 * h.second_weight * (1 - v.second_weight)};
  point.taps[3] = {level + 1, v.second * coarse.width + h.first, 0.5 * (1 - h.second_weight) * v.second_weight};
  point.taps[4] = {level + 1, v.second * coarse.width + h.second, 0.5 * h.second_weight * v.second_weight};
  return point;
}

std::vector<SamplePoint> make_points(const MovmfMipmap& mipmap, const AccuracySettings& settings) {
  std::vector<SamplePoint> points;
  SplitMix64 random(settings.seed);
  const int level_count = static_cast<int>(mipmap.levels.size());
  for (int l = settings.first_level; l < level_count; ++l) {
    const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (int texel : sampled_texels(level.width, level.height, settings.samples_per_level, random)) {
      const int x = texel % level.width, y = texel / level.width;
      points.push_back({AccuracyPoint::kCentre, l, {Tap{l, texel, 1.0}}, 1});
      if (x + 1 < level.width)
        points.push_back({AccuracyPoint::kMidX, l, {Tap{l, texel, 0.5}, Tap{l, texel + 1, 0.5}}, 2});
      if (y + 1 < level.height)
        points.push_back({AccuracyPoint::kMidY, l, {Tap{l, texel, 0.5}, Tap{l, texel + level.width, 0.5}}, 2});
      if (l + 1 < level_count) points.push_back(between_point(mipmap, l, x, y));
    }
  }
  return points;
}

// What a renderer reads at a tap: a stored lobe of its texel, or, of levels that are not stored, the average of the
// normal map (and of the colour map) over the texel as one more lobe behind those, of amplitude 1.
class TapReader {
 public:
  TapReader(const MovmfMipmap& mipmap, const NormalMap& map, const ColourMap* albedo)
      : mipmap_(mipmap), map_(map), albedo_(albedo) {}

  std::size_t lobe_count() const {
    return static_cast<std::size_t>(mipmap_.lobe_count()) + (mipmap_.first_level > 0 ? 1 : 0);
  }
  glm::dvec4 lobe(const Tap& tap, std::size_t lobe) const {
    if (!has_lobe(tap, lobe)) return glm::dvec4(0.0);
    if (tap.level < mipmap_.first_level) return {average(tap, {&map_.x, &map_.y, &map_.z}), 1.0};
    return glm::dvec4(stored(tap).lobes[lobe][static_cast<std::size_t>(tap.texel)]);
  }
  /// a y in one channel.
  double colour(const Tap& tap, std::size_t lobe, int channel) const {
    if (!has_lobe(tap, lobe)) return 0.0;
    if (tap.level < mipmap_.first_level) return average(tap, {&albedo_->r, &albedo_->g, &albedo_->b})[channel];
    return static_cast<double>(stored(tap).colours[lobe][static_cast<std::size_t>(tap.texel)][channel]);
  }

 private:
  bool has_lobe(const Tap& tap, std::size_t lobe) const {
    const bool is_map = lobe == static_cast<std::size_t>(mipmap_.lobe_count());
    return is_map == (tap.level < mipmap_.first_level);
  }
  const MovmfLevel& stored(const Tap& tap) const { return mipmap_.levels[static_cast<std::size_t>(tap.level)]; }
  glm::dvec3 average(const Tap& tap, const std::array<const std::vector<float>*, 3>& planes) const {
    const MovmfLevel& level = mipmap_.levels[static_cast<std::size_t>(tap.level)];
    return average_over_texel(planes, {map_.width, map_.height}, {level.width, level.height}, tap.texel);
  }

  const MovmfMipmap& mipmap_;
  const NormalMap& map_;
  const ColourMap* albedo_;
};

// The lobes at each point as hardware filtering gives them; multiplied by their colours in `channel` unless null:
// shading is linear in (a r, a), so T(a y) / T(a) times the lobe shades to T(a y) times its shape.
std::vector<glm::vec4> filtered_lobes(const TapReader& reader, const std::vector<SamplePoint>& points,
                                      std::size_t first, std::size_t count, const int* channel) {
  const std::size_t lobe_count = reader.lobe_count();
  std::vector<glm::vec4> lobes(count * lobe_count);
  for (std::size_t i = 0; i < count; ++i) {
    const SamplePoint& point = points[first + i];
    for (std::size_t j = 0; j < lobe_count; ++j) {
      glm::dvec4 sum(0.0);
      double colour = 0.0;
      for (int t = 0; t < point.tap_count; ++t) {
        const Tap& tap = point.taps[static_cast<std::size_t>(t)];
        sum += tap.weight * reader.lobe(tap, j);
        if (channel != nullptr) colour += tap.weight * reader.colour(tap, j, *channel);
      }
      if (channel != nullptr && sum.w > 0.0) sum *= colour / sum.w;
      lobes[i * lobe_count + j] = glm::vec4(sum);
    }
  }
  return lobes;
}

// x^n for whole n by squaring, else pow.
double power(double x, double exponent) {
  const auto whole = static_cast<unsigned>(exponent);
  if (exponent > 1e6 || static_cast<double>(whole) != exponent) return std::pow(x, exponent);
  double result = 1.0, square = x;
  for (unsigned bits = whole; bits != 0; bits >>= 1) {
    if ((bits & 1u) != 0) result *= square;
    square *= square;
  }
  return result;
}

class AccuracyMeter {
 public:
  AccuracyMeter(Device& device, const MovmfMipmap& mipmap, const NormalMap& map, const AccuracySettings& settings)
      : device_(device),
        mipmap_(mipmap),
        map_(map),
        settings_(settings),
        reader_(mipmap, map, settings.albedo),
        points_(make_points(mipmap, settings)),
        brdf_count_((settings.exponents.size() + 1) * (settings.albedo != nullptr ? 2 : 1)),
        difference_(points_.size() * brdf_count_, 0.0),
        truth_(points_.size() * brdf_count_, 0.0) {}

  std::vector<AccuracyRow> run(Progress* progress) {
    compare_all(0, nullptr, nullptr, progress);
    if (settings_.albedo != nullptr) {
      const std::vector<float>* planes[3] = {&settings_.albedo->r, &settings_.albedo->g, &settings_.albedo->b};
      for (int channel = 0; channel < 3; ++channel)
        compare_all(settings_.exponents.size() + 1, planes[channel], &channel, progress);
    }
    return rows();
  }

 private:
  // Every BRDF and direction; rows from `first_brdf` on. With a colour plane, f is multiplied by it and the lobes by
  // theirs.
  void compare_all(std::size_t first_brdf, const std::vector<float>* colour, const int* channel, Progress* progress) {
    shade_model(channel);
    const std::size_t half_count = settings_.directions.half_vectors.size();
    for (std::size_t d = 0; d < half_count; ++d) {
      for (std::size_t e = 0; e < settings_.exponents.size(); ++e)
        compare(first_brdf + e, e * half_count + d,
                truth_plane(settings_.directions.half_vectors[d], settings_.exponents[e], colour));
      progress_advance(progress, 0);  // a chance to cancel
    }
    for (std::size_t d = 0; d < settings_.directions.lights.size(); ++d)
      compare(first_brdf + settings_.exponents.size(), settings_.exponents.size() * half_count + d,
              truth_plane(settings_.directions.lights[d], 0.0, colour));
  }

  // Model values at every point, [point][value], by the runtime's formula on the device.
  void shade_model(const int* channel) {
    const std::size_t half_count = settings_.directions.half_vectors.size(),
                      light_count = settings_.directions.lights.size();
    value_count_ = settings_.exponents.size() * half_count + light_count;
    std::vector<glm::vec4> halfs, lights;
    for (const glm::dvec3& h : settings_.directions.half_vectors) halfs.emplace_back(glm::vec3(h), 0.0f);
    for (const glm::dvec3& l : settings_.directions.lights) lights.emplace_back(glm::vec3(l), 0.0f);
    const std::vector<float> exponents(settings_.exponents.begin(), settings_.exponents.end());
    const DeviceBuffer half_buffer =
        device_.wrap_buffer(halfs.data(), halfs.size() * sizeof(glm::vec4), "half vectors");
    const DeviceBuffer light_buffer = device_.wrap_buffer(lights.data(), lights.size() * sizeof(glm::vec4), "lights");
    const DeviceBuffer exponent_buffer =
        device_.wrap_buffer(exponents.data(), exponents.size() * sizeof(float), "exponents");
    Kernel kernel = device_.kernel("movmf_shade", "movmf_shade", {static_cast<int>(reader_.lobe_count()), 1, false});
    model_.resize(points_.size() * value_count_);
    constexpr std::size_t kBatch = 1 << 16;
    DeviceBuffer values =
        device_.make_buffer(std::min(kBatch, points_.size()) * value_count_ * sizeof(float), "shaded values");
    for (std::size_t first = 0; first < points_.size(); first += kBatch) {
      const std::size_t count = std::min(kBatch, points_.size() - first);
      const std::vector<glm::vec4> lobes = filtered_lobes(reader_, points_, first, count, channel);
      const DeviceBuffer lobe_buffer =
          device_.wrap_buffer(lobes.data(), lobes.size() * sizeof(glm::vec4), "filtered lobes");
      kernel.launch({count}, lobe_buffer, half_buffer, light_buffer, exponent_buffer, values, static_cast<int>(count),
                    static_cast<int>(half_count), static_cast<int>(light_count), static_cast<int>(exponents.size()));
      device_.read(values, model_.data() + first * value_count_, count * value_count_ * sizeof(float));
    }
  }

  // f(omega . n) of every finest normal: normalised Blinn-Phong, or max(t, 0) for exponent 0.
  Plane truth_plane(const glm::dvec3& omega, double exponent, const std::vector<float>* colour) const {
    Plane plane(map_.x.size());
    const double scale = exponent > 0.0 ? (exponent + 1.0) / (2.0 * M_PI) : 1.0;
    const auto width = static_cast<std::size_t>(map_.width);
    for_each_item(map_.height, settings_.threads, [&](int y) {
      const std::size_t begin = static_cast<std::size_t>(y) * width;
      for (std::size_t i = begin; i < begin + width; ++i) {
        const double t =
            std::max(0.0, omega.x * static_cast<double>(map_.x[i]) + omega.y * static_cast<double>(map_.y[i]) +
                              omega.z * static_cast<double>(map_.z[i]));
        plane[i] = exponent > 0.0 ? scale * power(t, exponent) : t;
        if (colour != nullptr) plane[i] *= static_cast<double>((*colour)[i]);
      }
    });
    return plane;
  }

  // The truth of every level, from level 0: its averages over what each texel covers.
  std::vector<Plane> truth_pyramid(Plane finest) const {
    std::vector<Plane> levels;
    levels.push_back(std::move(finest));
    const PlaneSize full = {map_.width, map_.height};
    PlaneSize above = full;
    for (std::size_t l = 1; l < mipmap_.levels.size(); ++l) {
      const PlaneSize size = {mipmap_.levels[l].width, mipmap_.levels[l].height};
      // Where blocks nest, averages of averages are the same and cheaper.
      const bool nested = above.width % size.width == 0 && above.height % size.height == 0 &&
                          full.width % above.width == 0 && full.height % above.height == 0;
      levels.push_back(nested ? average_over_texels(levels[l - 1], above, size, settings_.threads)
                              : average_over_texels(levels[0], full, size, settings_.threads));
      above = size;
    }
    return levels;
  }

  void compare(std::size_t brdf, std::size_t value, Plane finest) {
    const std::vector<Plane> truth = truth_pyramid(std::move(finest));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      double sum = 0.0;
      for (int t = 0; t < points_[i].tap_count; ++t) {
        const Tap& tap = points_[i].taps[static_cast<std::size_t>(t)];
        sum += tap.weight * truth[static_cast<std::size_t>(tap.level)][static_cast<std::size_t>(tap.texel)];
      }
      difference_[i * brdf_count_ + brdf] += std::abs(static_cast<double>(model_[i * value_count_ + value]) - sum);
      truth_[i * brdf_count_ + brdf] += sum;
    }
  }

  std::string brdf_name(std::size_t brdf) const {
    const std::size_t plain_count = settings_.exponents.size() + 1;
    const std::size_t plain = brdf % plain_count;
    const std::string name =
        plain + 1 == plain_count ? "lambert" : fmt::format("blinn-phong:{}", settings_.exponents[plain]);
    return brdf < plain_count ? name : name + " coloured";
  }

  // Ratio of sums, and the half width of its 95 % interval by the delta method, over the points of one level and kind.
  AccuracyRow row(int level, AccuracyPoint kind, std::size_t brdf) const {
    AccuracyRow row{level, kind, brdf_name(brdf), 0.0, 0.0, 0};
    double difference = 0.0, truth = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].level != level || points_[i].kind != kind) continue;
      difference += difference_[i * brdf_count_ + brdf];
      truth += truth_[i * brdf_count_ + brdf];
      ++row.sample_count;
    }
    if (!(truth > 0.0)) return row;
    row.error = difference / truth;
    const MovmfLevel& size = mipmap_.levels[static_cast<std::size_t>(level)];
    const bool all =
        settings_.samples_per_level <= 0 || std::int64_t{size.width} * size.height <= settings_.samples_per_level;
    if (all || row.sample_count < 2) return row;
    double squares = 0.0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].level != level || points_[i].kind != kind) continue;
      const double residual = difference_[i * brdf_count_ + brdf] - row.error * truth_[i * brdf_count_ + brdf];
      squares += residual * residual;
    }
    const auto n = static_cast<double>(row.sample_count);
    row.confidence = 1.96 * std::sqrt(squares / (n * (n - 1))) / (truth / n);
    return row;
  }

  std::vector<AccuracyRow> rows() const {
    std::vector<AccuracyRow> rows;
    for (int l = 0; l < static_cast<int>(mipmap_.levels.size()); ++l)
      for (AccuracyPoint kind :
           {AccuracyPoint::kCentre, AccuracyPoint::kMidX, AccuracyPoint::kMidY, AccuracyPoint::kBetween})
        for (std::size_t b = 0; b < brdf_count_; ++b) {
          AccuracyRow made = row(l, kind, b);
          if (made.sample_count > 0) rows.push_back(std::move(made));
        }
    return rows;
  }

  Device& device_;
  const MovmfMipmap& mipmap_;
  const NormalMap& map_;
  const AccuracySettings settings_;
  const TapReader reader_;
  const std::vector<SamplePoint> points_;
  const std::size_t brdf_count_;  // exponents, then Lambert
  std::size_t value_count_ = 0;
  std::vector<float> model_;        // [point][value]
  std::vector<double> difference_;  // [point][brdf], summed over directions
  std::vector<double> truth_;
};

}  // namespace

const char* accuracy_point_name(AccuracyPoint point) {
  switch (point) {
    case AccuracyPoint::kCentre: return "centre";
    case AccuracyPoint::kMidX: return "midway-x";
    case AccuracyPoint::kMidY: return "midway-y";
    case AccuracyPoint::kBetween: return "between-levels";
  }
  return "?";
}

AccuracyDirections accuracy_directions() {
  AccuracyDirections directions;
  for (const glm::dvec3& light :
       {glm::dvec3(.3, .2, .93), glm::dvec3(-.7, .1, .7), glm::dvec3(.1, -.9, .45), glm::dvec3(.5, .6, .6)})
    directions.lights.push_back(glm::normalize(light));
  for (const glm::dvec3& light : directions.lights)
    for (const glm::dvec3& view : {glm::dvec3(0, 0, 1), glm::dvec3(.6, 0, .8), glm::dvec3(-.3, .7, .6)})
      directions.half_vectors.push_back(glm::normalize(light + glm::normalize(view)));
  return directions;
}

std::vector<AccuracyRow> measure_accuracy(Device& device, const MovmfMipmap& mipmap, const NormalMap& map,
                                          const AccuracySettings& settings, Progress* progress) {
  MULTUM_CHECK(mipmap.width() == map.width && mipmap.height() == map.height);
  return AccuracyMeter(device, mipmap, map, settings).run(progress);
}

}  // namespace multum
