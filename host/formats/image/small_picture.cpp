// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/small_picture.h"

#include <algorithm>
#include <cmath>

#include "host/formats/image/image_reader.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The weights with which an input contributes to one or two outputs. A line has `from` inputs and `to` <= `from`
// outputs.
struct Share {
  int first = 0;
  double first_weight = 0.0, second_weight = 0.0;  // the weights of one output sum to 1
};

std::vector<Share> make_shares(int from, int to) {
  std::vector<Share> shares(static_cast<std::size_t>(from));
  const double scale = static_cast<double>(to) / from;
  for (int i = 0; i < from; ++i) {
    Share& share = shares[static_cast<std::size_t>(i)];
    const double begin = i * scale, end = (i + 1) * scale;
    share.first = std::min(to - 1, static_cast<int>(begin));
    const double border = share.first + 1.0;
    const bool is_inside = end <= border || share.first == to - 1;
    share.first_weight = is_inside ? scale : border - begin;
    share.second_weight = is_inside ? 0.0 : end - border;
  }
  return shares;
}

// Sums over areas; the weights of Share turn the sums into means.
class AreaMeans {
 public:
  AreaMeans(const RawImageInfo& info, int width, int height)
      : channels_(info.channel_count),
        width_(width),
        columns_(make_shares(info.width, width)),
        rows_(make_shares(info.height, height)),
        row_sums_(static_cast<std::size_t>(width * channels_)),
        sums_(static_cast<std::size_t>(width * channels_) * static_cast<std::size_t>(height)) {}

  void add_row(int row, const float* values) {
    std::fill(row_sums_.begin(), row_sums_.end(), 0.0);
    for (std::size_t x = 0; x < columns_.size(); ++x) {
      const Share& share = columns_[x];
      for (int c = 0; c < channels_; ++c) {
        const double value = std::isfinite(*values) ? static_cast<double>(*values) : 0.0;
        ++values;
        const auto at = static_cast<std::size_t>(share.first * channels_ + c);
        row_sums_[at] += share.first_weight * value;
        if (share.second_weight > 0.0)
          row_sums_[at + static_cast<std::size_t>(channels_)] += share.second_weight * value;
      }
    }
    const Share& share = rows_[static_cast<std::size_t>(row)];
    add_sums(share.first, share.first_weight);
    if (share.second_weight > 0.0) add_sums(share.first + 1, share.second_weight);
  }
  const std::vector<double>& means() const { return sums_; }

 private:
  void add_sums(int row, double weight) {
    const std::size_t begin = row_sums_.size() * static_cast<std::size_t>(row);
    for (std::size_t i = 0; i < row_sums_.size(); ++i) sums_[begin + i] += weight * row_sums_[i];
  }

  int channels_, width_;
  std::vector<Share> columns_, rows_;
  std::vector<double> row_sums_, sums_;
};

// Returns the values that are shown as black and as white.
std::pair<double, double> range_of(const std::vector<double>& means, const RawImageInfo& info) {
  const auto [least, most] = std::minmax_element(means.begin(), means.end());
  if (info.channel_count == 1) return {*least, *most};
  if (!is_float_type(info.sample_type)) return {0.0, 1.0};
  if (*least < 0.0) return {std::min(-1.0, *least), std::max(1.0, *most)};
  return {0.0, std::max(1.0, *most)};
}

}  // namespace

Png8Image read_small_picture(const std::string& path, int side_max) {
  ImageReader reader(path, {});
  const RawImageInfo& info = reader.info();
  const double scale = std::min(1.0, static_cast<double>(side_max) / std::max(info.width, info.height));
  const auto small = [&](int side) { return std::max(1, static_cast<int>(std::lround(side * scale))); };
  Png8Image picture{small(info.width), small(info.height), info.channel_count == 1 ? 1 : 3, {}};
  AreaMeans sums(info, picture.width, picture.height);
  const SampleConverter converter(info.base_type);
  std::vector<float> row(info.row_values());
  reader.read(
      [&](const RawBand& band) {
        for (int y = 0; y < band.row_count; ++y) {
          converter.convert(band.samples + static_cast<std::size_t>(y) * info.row_bytes, row.size(), row.data());
          sums.add_row(band.first_row + y, row.data());
        }
      },
      nullptr);
  const auto [black, white] = range_of(sums.means(), info);
  for (std::size_t i = 0; i < sums.means().size(); ++i) {
    const double value = white > black ? (sums.means()[i] - black) / (white - black) : 0.5;
    picture.interleaved.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0))));
    if (info.channel_count == 2 && i % 2 == 1) picture.interleaved.push_back(255);
  }
  return picture;
}

}  // namespace multum
