// SPDX-License-Identifier: Apache-2.0
// A pixel b = sum_k c_k b_k has coverages c_k that sum to 1, including the background. m_k is the appearance of object
// k nearby. The parts that add up to the pixel, and are nearest to m_k in least squares, are
//     b_k = m_k + r c_k / sum_j c_j^2,   r = b - sum_j c_j m_j.
// Values are clipped last. With earlier clipping, an object's highlight would leak into the objects that share its
// pixels.
#include "host/fields/inference/mapping/layer_segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

using Colour = std::array<double, 3>;

enum class PixelState : std::uint8_t { kValid, kNotFinite, kNegative };

struct GaussKernel {
  int radius;
  std::vector<double> weights;  // weights by distance along one axis; the weights of both axes are multiplied
};

// Makes a kernel for sigma, and kernels for the doubled sigmas up to sigma_max.
std::vector<GaussKernel> make_kernels(const SegmentationSettings& settings) {
  std::vector<GaussKernel> kernels;
  for (double sigma = settings.sigma; kernels.empty() || sigma <= settings.sigma_max; sigma *= 2.0) {
    GaussKernel kernel{static_cast<int>(std::ceil(3.0 * sigma)), {}};
    for (int d = 0; d <= kernel.radius; ++d) kernel.weights.push_back(std::exp(-0.5 * d * d / (sigma * sigma)));
    kernels.push_back(std::move(kernel));
  }
  return kernels;
}

/// The picture, with the background as the last object. Tables are used to find in constant time whether a window
/// contains a wholly covered pixel.
class Segmentation {
 public:
  Segmentation(const SegmentationInput& input, const SegmentationSettings& settings);
  std::vector<ObjectLayer> layers(SegmentationReport* report) const;

 private:
  struct Part {
    std::size_t object;
    double coverage;
    Colour near;  // m_k
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  // Limits coverage to 0..1. A NaN counts as 0, because the fault is only in the coverage, not in the picture.
  double coverage(std::size_t object, std::size_t pixel) const {
    const float c = object < input_.coverages.size() ? input_.coverages[object][pixel] : background_[pixel];
    return c > 0.0f ? std::min(1.0, static_cast<double>(c)) : 0.0;
  }
  bool is_whole(std::size_t object, std::size_t pixel) const {
    return state_[pixel] == PixelState::kValid && coverage(object, pixel) >= settings_.coverage_whole;
  }
  Colour value(std::size_t pixel) const {
    const float* const rgb = &input_.rgb[3 * pixel];
    return {static_cast<double>(rgb[0]), static_cast<double>(rgb[1]), static_cast<double>(rgb[2])};
  }
  void count_whole(std::size_t object);
  bool whole_in_reach(std::size_t object, int x, int y, int radius) const;
  bool nearby(std::size_t object, int x, int y, Colour* mean) const;
  void unmix(int x, int y, std::vector<ObjectLayer>* layers, SegmentationReport* report) const;
  bool repair(const ObjectLayer& layer, std::size_t object, int x, int y, Colour* mean) const;
  void store(const Colour& colour, std::size_t pixel, ObjectLayer* layer, SegmentationReport* report) const;
  void repair_object(std::size_t object, ObjectLayer* layer, SegmentationReport* report) const;

  const SegmentationInput& input_;
  const SegmentationSettings& settings_;
  int width_, height_;
  std::vector<GaussKernel> kernels_;
  std::vector<float> background_;
  std::vector<PixelState> state_;
  // For each object, a summed-area table with the number of pixels above and to the left.
  std::vector<std::vector<std::int32_t>> whole_count_;
};

Segmentation::Segmentation(const SegmentationInput& input, const SegmentationSettings& settings)
    : input_(input), settings_(settings), width_(input.width), height_(input.height), kernels_(make_kernels(settings)) {
  const std::size_t count = index(0, height_);
  background_.resize(count);
  state_.resize(count, PixelState::kValid);
  for (std::size_t pixel = 0; pixel < count; ++pixel) {
    double covered = 0.0;
    for (std::size_t object = 0; object < input.coverages.size(); ++object) covered += coverage(object, pixel);
    background_[pixel] = static_cast<float>(std::max(0.0, 1.0 - covered));
    for (const double v : value(pixel)) {
      if (!std::isfinite(v)) state_[pixel] = PixelState::kNotFinite;
      if (v < settings.radiance_min && state_[pixel] == PixelState::kValid) state_[pixel] = PixelState::kNegative;
    }
  }
  whole_count_.resize(input.coverages.size() + 1);
  for_each_item(static_cast<int>(whole_count_.size()), settings.threads,
                [&](int object) { count_whole(static_cast<std::size_t>(object)); });
}

void Segmentation::count_whole(std::size_t object) {
  const std::size_t pitch = static_cast<std::size_t>(width_) + 1;
  std::vector<std::int32_t>& table = whole_count_[object];
  table.assign(pitch * (static_cast<std::size_t>(height_) + 1), 0);
  for (int y = 0; y < height_; ++y) {
    std::int32_t row = 0;
    for (int x = 0; x < width_; ++x) {
      row += is_whole(object, index(x, y)) ? 1 : 0;
      const std::size_t at = static_cast<std::size_t>(y) * pitch + static_cast<std::size_t>(x) + 1;
      table[at + pitch] = table[at] + row;
    }
  }
}

bool Segmentation::whole_in_reach(std::size_t object, int x, int y, int radius) const {
  const std::size_t pitch = static_cast<std::size_t>(width_) + 1;
  const auto x0 = static_cast<std::size_t>(std::max(0, x - radius));
  const auto x1 = static_cast<std::size_t>(std::min(width_, x + radius + 1));
  const std::size_t y0 = static_cast<std::size_t>(std::max(0, y - radius)) * pitch;
  const std::size_t y1 = static_cast<std::size_t>(std::min(height_, y + radius + 1)) * pitch;
  const std::vector<std::int32_t>& table = whole_count_[object];
  return table[y1 + x1] - table[y1 + x0] - table[y0 + x1] + table[y0 + x0] > 0;
}

// Computes m_k. The picture under the object's mask is filtered by a Gaussian and divided by the filtered mask.
bool Segmentation::nearby(std::size_t object, int x, int y, Colour* mean) const {
  const auto kernel = std::find_if(kernels_.begin(), kernels_.end(), [&](const GaussKernel& candidate) {
    return whole_in_reach(object, x, y, candidate.radius);
  });
  if (kernel == kernels_.end()) return false;
  Colour sum{};
  double weight_sum = 0.0;
  for (int v = std::max(0, y - kernel->radius); v <= std::min(height_ - 1, y + kernel->radius); ++v)
    for (int u = std::max(0, x - kernel->radius); u <= std::min(width_ - 1, x + kernel->radius); ++u) {
      if (!is_whole(object, index(u, v))) continue;
      const double weight = kernel->weights[static_cast<std::size_t>(std::abs(u - x))] *
                            kernel->weights[static_cast<std::size_t>(std::abs(v - y))];
      const Colour colour = value(index(u, v));
      for (std::size_t i = 0; i < 3; ++i) sum[i] += weight * colour[i];
      weight_sum += weight;
    }
  for (std::size_t i = 0; i < 3; ++i) (*mean)[i] = sum[i] / weight_sum;
  return true;
}

void Segmentation::store(const Colour& colour, std::size_t pixel, ObjectLayer* layer,
                         SegmentationReport* report) const {
  for (std::size_t i = 0; i < 3; ++i) {
    report->clamped_values += colour[i] < 0.0;
    report->clipped_values += colour[i] > settings_.radiance_max;
    layer->rgb[3 * pixel + i] = static_cast<float>(std::clamp(colour[i], 0.0, settings_.radiance_max));
  }
}

void Segmentation::unmix(int x, int y, std::vector<ObjectLayer>* layers, SegmentationReport* report) const {
  const std::size_t pixel = index(x, y);
  if (state_[pixel] != PixelState::kValid) return;
  const Colour b = value(pixel);
  for (std::size_t object = 0; object < layers->size(); ++object)
    if (is_whole(object, pixel)) {
      store(b, pixel, &(*layers)[object], report);
      return;
    }
  std::vector<Part> parts;
  Colour rest = b;
  double square_sum = 0.0;
  for (std::size_t object = 0; object <= layers->size(); ++object) {
    Part part{object, coverage(object, pixel), b};
    if (!(part.coverage > 0.0)) continue;
    const bool is_kept = object < layers->size() && (*layers)[object].coverage[pixel] > 0.0f;
    const bool is_guided = nearby(object, x, y, &part.near);
    report->mixed_pixels += is_kept;
    report->unguided_pixels += is_kept && !is_guided;
    for (std::size_t i = 0; i < 3; ++i) rest[i] -= part.coverage * part.near[i];
    square_sum += part.coverage * part.coverage;
    parts.push_back(part);
  }
  for (const Part& part : parts) {
    if (part.object == layers->size() || !((*layers)[part.object].coverage[pixel] > 0.0f)) continue;
    Colour colour;
    for (std::size_t i = 0; i < 3; ++i) colour[i] = part.near[i] + rest[i] * part.coverage / square_sum;
    store(colour, pixel, &(*layers)[part.object], report);
  }
}

// Replaces a value by the Gaussian mean of the object's valid values, weighted by coverage.
bool Segmentation::repair(const ObjectLayer& layer, std::size_t object, int x, int y, Colour* mean) const {
  const GaussKernel& kernel = kernels_.front();
  Colour sum{};
  double weight_sum = 0.0;
  for (int v = std::max(0, y - kernel.radius); v <= std::min(height_ - 1, y + kernel.radius); ++v)
    for (int u = std::max(0, x - kernel.radius); u <= std::min(width_ - 1, x + kernel.radius); ++u) {
      const std::size_t pixel = index(u, v);
      if (state_[pixel] != PixelState::kValid || !(layer.coverage[pixel] > 0.0f)) continue;
      const double weight = coverage(object, pixel) * kernel.weights[static_cast<std::size_t>(std::abs(u - x))] *
                            kernel.weights[static_cast<std::size_t>(std::abs(v - y))];
      for (std::size_t i = 0; i < 3; ++i) sum[i] += weight * static_cast<double>(layer.rgb[3 * pixel + i]);
      weight_sum += weight;
    }
  if (!(weight_sum > 0.0)) return false;
  for (std::size_t i = 0; i < 3; ++i) (*mean)[i] = sum[i] / weight_sum;
  return true;
}

// Reads only valid pixels and writes only invalid ones, so the order of pixels does not matter.
void Segmentation::repair_object(std::size_t object, ObjectLayer* layer, SegmentationReport* report) const {
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::size_t pixel = index(x, y);
      if (state_[pixel] == PixelState::kValid || !(layer->coverage[pixel] > 0.0f)) continue;
      ++(state_[pixel] == PixelState::kNotFinite ? report->not_finite_pixels : report->negative_pixels);
      Colour mean;
      if (repair(*layer, object, x, y, &mean)) {
        ++report->repaired_pixels;
        store(mean, pixel, layer, report);
      } else {
        ++report->dropped_pixels;
        layer->coverage[pixel] = 0.0f;
      }
    }
}

std::vector<ObjectLayer> Segmentation::layers(SegmentationReport* report) const {
  std::vector<ObjectLayer> layers(input_.coverages.size());
  const std::size_t count = state_.size();
  for (std::size_t object = 0; object < layers.size(); ++object) {
    layers[object].rgb.assign(3 * count, 0.0f);
    layers[object].coverage.resize(count);
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
      const double c = coverage(object, pixel);
      layers[object].coverage[pixel] = c >= settings_.coverage_min ? static_cast<float>(c) : 0.0f;
    }
  }
  std::vector<SegmentationReport> rows(static_cast<std::size_t>(height_)), objects(layers.size());
  for_each_item(height_, settings_.threads, [&](int y) {
    for (int x = 0; x < width_; ++x) unmix(x, y, &layers, &rows[static_cast<std::size_t>(y)]);
  });
  for_each_item(static_cast<int>(layers.size()), settings_.threads, [&](int i) {
    const auto object = static_cast<std::size_t>(i);
    repair_object(object, &layers[object], &objects[object]);
  });
  for (const SegmentationReport& part : rows) report->add(part);
  for (const SegmentationReport& part : objects) report->add(part);
  return layers;
}

}  // namespace

std::vector<ObjectLayer> segment_layer(const SegmentationInput& input, const SegmentationSettings& settings,
                                       SegmentationReport* report) {
  MULTUM_CHECK(input.width >= 1 && input.height >= 1 && settings.sigma > 0.0 && settings.radiance_max > 0.0);
  const std::size_t count = static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height);
  MULTUM_CHECK(input.rgb.size() == 3 * count);
  for (const auto& coverage : input.coverages) MULTUM_CHECK(coverage.size() == count);
  SegmentationReport own;
  std::vector<ObjectLayer> layers = Segmentation(input, settings).layers(&own);
  if (report != nullptr) *report = own;
  return layers;
}

void SegmentationReport::add(const SegmentationReport& other) {
  not_finite_pixels += other.not_finite_pixels;
  negative_pixels += other.negative_pixels;
  repaired_pixels += other.repaired_pixels;
  dropped_pixels += other.dropped_pixels;
  mixed_pixels += other.mixed_pixels;
  unguided_pixels += other.unguided_pixels;
  clamped_values += other.clamped_values;
  clipped_values += other.clipped_values;
}

bool has_radiance(const ObjectLayer& layer, double radiance_max) {
  constexpr double kShare = 1.0 / 4096;
  // Silhouette pixels may contain colours of other objects, so they count only if there are no other pixels.
  for (const float coverage_min : {kWholeCoverage, 0.0f}) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t pixel = 0; pixel < layer.coverage.size(); ++pixel) {
      if (layer.coverage[pixel] <= 0.0f || layer.coverage[pixel] < coverage_min) continue;
      ++count;
      double largest = 0.0;
      for (std::size_t i = 0; i < 3; ++i) largest = std::max(largest, static_cast<double>(layer.rgb[3 * pixel + i]));
      sum += largest * largest;
    }
    if (count > 0) return std::sqrt(sum / static_cast<double>(count)) > kShare * radiance_max;
  }
  return false;
}

}  // namespace multum
