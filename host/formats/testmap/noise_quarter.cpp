// SPDX-License-Identifier: Apache-2.0
#include "host/formats/testmap/noise_quarter.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr int kRadius = 6;  // radius at which a Gaussian of 0.8 texels is 1e-12 of its peak

std::vector<double> gaussian_weights() {
  constexpr double kSigma = 0.8;
  std::vector<double> weights(2 * kRadius + 1);
  double sum = 0.0;
  for (int i = -kRadius; i <= kRadius; ++i)
    sum += weights[static_cast<std::size_t>(i + kRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  for (double& weight : weights) weight /= sum;
  return weights;
}

int wrapped(int index, int count) { return ((index % count) + count) % count; }

// Uses the method of Box and Muller (1958). Both numbers of a pair are used, in row order, so a pair may span two rows.
std::vector<double> white_noise_row(int size, int row, std::uint64_t seed) {
  const std::uint64_t begin = static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(size);
  const std::uint64_t end = begin + static_cast<std::uint64_t>(size);
  const std::uint64_t first_pair = begin / 2 * 2;
  SplitMix64 generator(seed, first_pair);
  std::vector<double> values(static_cast<std::size_t>(size));
  for (std::uint64_t i = first_pair; i < end; i += 2) {
    const double radius = std::sqrt(-2.0 * std::log(generator.uniform()));
    const double angle = 2.0 * std::numbers::pi * generator.uniform();
    if (i >= begin) values[i - begin] = radius * std::cos(angle);
    if (i + 1 < end) values[i + 1 - begin] = radius * std::sin(angle);
  }
  return values;
}

std::vector<double> filtered_along_row(const std::vector<double>& row, const std::vector<double>& weights) {
  const int size = static_cast<int>(row.size());
  std::vector<double> padded;
  for (int column = -kRadius; column < size + kRadius; ++column)
    padded.push_back(row[static_cast<std::size_t>(wrapped(column, size))]);
  std::vector<double> result(row.size());
  for (std::size_t column = 0; column < row.size(); ++column)
    for (std::size_t i = 0; i < weights.size(); ++i) result[column] += weights[i] * padded[column + i];
  return result;
}

}  // namespace

std::shared_ptr<const std::vector<double>> NoiseQuarter::RecentRows::row(int row) {
  const int inside = wrapped(row, height_);
  Kept& kept = kept_[static_cast<std::size_t>(inside) % kept_.size()];
  if (kept.row != inside) kept = {inside, std::make_shared<const Row>(make_(inside))};
  return kept.values;
}

NoiseQuarter::NoiseQuarter(int size, std::uint64_t seed)
    : size_(size),
      weights_(gaussian_weights()),
      filtered_along_rows_(
          size, 16, [this, seed](int row) { return filtered_along_row(white_noise_row(size_, row, seed), weights_); }),
      filtered_(size, 4, [this](int row) {
        Row result(static_cast<std::size_t>(size_));
        for (int i = -kRadius; i <= kRadius; ++i) {
          const auto source = filtered_along_rows_.row(row + i);
          const double weight = weights_[static_cast<std::size_t>(i + kRadius)];
          for (std::size_t column = 0; column < result.size(); ++column) result[column] += weight * (*source)[column];
        }
        return result;
      }) {
  double square_sum = 0.0;
  for (int row = 0; row < size; ++row)
    for (const double difference : differences_x(row)) square_sum += difference * difference;
  scale_ = 0.45 / std::sqrt(square_sum / (static_cast<double>(size) * size));
}

std::vector<double> NoiseQuarter::differences_x(int row) {
  const auto values = filtered_.row(row);
  Row differences(values->size());
  for (int column = 0; column < size_; ++column)
    differences[static_cast<std::size_t>(column)] = (*values)[static_cast<std::size_t>(wrapped(column + 1, size_))] -
                                                    (*values)[static_cast<std::size_t>(wrapped(column - 1, size_))];
  return differences;
}

NoiseSlopes NoiseQuarter::row(int row) {
  const auto above = filtered_.row(row - 1);
  NoiseSlopes slopes{differences_x(row), Row(static_cast<std::size_t>(size_))};
  const auto below = filtered_.row(row + 1);
  for (int column = 0; column < size_; ++column) {
    const auto i = static_cast<std::size_t>(column);
    const double gain = scale_ * (0.4 + 1.2 * (column + 0.5) / size_);
    slopes.x[i] *= gain;
    slopes.y[i] = gain * ((*below)[i] - (*above)[i]);
  }
  return slopes;
}

}  // namespace multum
