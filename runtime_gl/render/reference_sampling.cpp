// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/reference_sampling.h"

#include <cmath>
#include <limits>

#include "host/foundation/base/error.h"

namespace multum::gl {
namespace {

constexpr double kGaussianSigma = 0.5;
constexpr double kGaussianRadius = 1.5;

// Inverts the cumulative normal distribution function by bisection. The function is called only twice per sample of a
// picture.
double gaussian_offset(double u) {
  const auto cumulative = [](double x) { return 0.5 * std::erfc(-x / (kGaussianSigma * std::sqrt(2.0))); };
  const double low_tail = cumulative(-kGaussianRadius);
  const double wanted = low_tail + u * (1.0 - 2.0 * low_tail);
  double low = -kGaussianRadius, high = kGaussianRadius;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (cumulative(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double filter_offset(PixelFilter filter, double u) {
  switch (filter) {
    case PixelFilter::kBox: return u - 0.5;
    case PixelFilter::kTent: return u < 0.5 ? std::sqrt(2.0 * u) - 1.0 : 1.0 - std::sqrt(2.0 * (1.0 - u));
    case PixelFilter::kGaussian: return gaussian_offset(u);
  }
  return 0.0;
}

}  // namespace

glm::vec2 reference_offset(PixelFilter filter, int sample) {
  const double x = 0.5 + 0.7548776662466927 * (sample + 1);
  const double y = 0.5 + 0.5698402909980532 * (sample + 1);
  return {static_cast<float>(filter_offset(filter, x - std::floor(x))),
          static_cast<float>(filter_offset(filter, y - std::floor(y)))};
}

ReferenceSum::ReferenceSum(int width, int height) : width_(width), height_(height) {
  for (std::vector<double>& half : halves_)
    half.assign(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0);
}

void ReferenceSum::add(const FloatImage& sum, int sample_count) {
  std::vector<double>& half = halves_[static_cast<std::size_t>(next_)];
  MULTUM_CHECK(sum.rgba.size() == half.size());
  for (std::size_t i = 0; i < half.size(); ++i) half[i] += static_cast<double>(sum.rgba[i]);
  counts_[static_cast<std::size_t>(next_)] += sample_count;
  next_ = 1 - next_;
}

double ReferenceSum::noise() const {
  if (counts_[0] == 0 || counts_[1] == 0) return std::numeric_limits<double>::infinity();
  double difference = 0.0, total = 0.0;
  for (std::size_t i = 0; i < halves_[0].size(); ++i) {
    if (i % 4 == 3) continue;
    const double a = halves_[0][i] / counts_[0], b = halves_[1][i] / counts_[1];
    difference += 0.5 * std::abs(a - b);
    total += 0.5 * (a + b);
  }
  return total > 0.0 ? difference / total : 0.0;
}

FloatImage ReferenceSum::mean() const {
  FloatImage image{width_, height_, std::vector<float>(halves_[0].size())};
  for (std::size_t i = 0; i < image.rgba.size(); ++i)
    image.rgba[i] = static_cast<float>((halves_[0][i] + halves_[1][i]) / sample_count());
  return image;
}

}  // namespace multum::gl
