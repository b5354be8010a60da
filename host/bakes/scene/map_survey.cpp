// SPDX-License-Identifier: Apache-2.0
// Reads rows in bands. A band consists of the finest rows that one row of level kBandLevel covers. Bands are divided
// among threads, and sums are formed in the same order for any number of threads:
//
//     finest row -> sums of level 1 -> ... -> sums of level kBandLevel      in a band
//                                             -> ... -> the coarsest level  after all bands
#include "host/bakes/scene/map_survey.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr int kBandLevel = 5;
// On larger maps, sums include only every fourth band. Ranges always include every texel.
constexpr std::int64_t kSummedTexels = std::int64_t{1} << 22;
constexpr int kBandStride = 4;

// The sums over the normals that a texel covers.
struct Sums {
  double count = 0.0, x = 0.0, y = 0.0, z = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;

  void add(const Sums& other) {
    count += other.count;
    x += other.x, y += other.y, z += other.z;
    xx += other.xx, yy += other.yy, xy += other.xy;
  }
};
using SumRow = std::vector<Sums>;
struct NumberedRow {
  int number;  // position in its level
  SumRow sums;
};

// The sums over a level, updated as its texels arrive.
struct LevelSums {
  double texels = 0.0, spread = 0.0, spread_max = 0.0, difference = 0.0, variance = 0.0;

  void add(const SumRow& row) {
    for (const Sums& s : row) {
      const double x = s.x / s.count, y = s.y / s.count, z = s.z / s.count;
      const double here = std::max(1.0 - std::sqrt(x * x + y * y + z * z), 0.0);
      const double xx = std::max(s.xx / s.count - x * x, 0.0), yy = std::max(s.yy / s.count - y * y, 0.0);
      texels += 1.0;
      spread += here;
      spread_max = std::max(spread_max, here);
      // Absolute values are at most 2, so hypot() is not needed.
      const double along = xx - yy, across = 2.0 * (s.xy / s.count - x * y);
      difference += std::sqrt(along * along + across * across);
      variance += xx + yy;
    }
  }
  void add(const LevelSums& other) {
    texels += other.texels;
    spread += other.spread;
    spread_max = std::max(spread_max, other.spread_max);
    difference += other.difference;
    variance += other.variance;
  }
};

// Returns the row or column of the next coarser level that contains row or column `index`.
int parent_of(int index, int size, int parent_size) {
  return static_cast<int>(std::int64_t{index} * parent_size / size);
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  // The lanes are independent, so that one instruction handles several values.
  void add(const std::vector<float>& values) {
    constexpr std::size_t kLanes = 16;
    std::array<float, kLanes> lows{}, highs{};
    lows.fill(values.front());
    highs.fill(values.front());
    for (std::size_t i = 0; i + kLanes <= values.size(); i += kLanes)
      for (std::size_t k = 0; k < kLanes; ++k) {
        lows[k] = std::min(lows[k], values[i + k]);
        highs[k] = std::max(highs[k], values[i + k]);
      }
    for (std::size_t i = values.size() / kLanes * kLanes; i < values.size(); ++i) {
      lows[0] = std::min(lows[0], values[i]);
      highs[0] = std::max(highs[0], values[i]);
    }
    low = std::min(low, static_cast<double>(*std::min_element(lows.begin(), lows.end())));
    high = std::max(high, static_cast<double>(*std::max_element(highs.begin(), highs.end())));
  }
  void add(const Range& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
  }
  double size() const { return high - low; }
};

// A chosen texel of the finest level and the place where its values are stored.
struct Pick {
  int row, column;
  std::size_t texel, index;
};

// Returns a random position in cell `cell` of the `cells` cells that divide [begin, end).
int position(int cell, int cells, int begin, int end, std::uint64_t random) {
  const std::int64_t size = end - begin, first = cell * size / cells, last = (cell + 1) * size / cells;
  return begin + static_cast<int>(first + static_cast<std::int64_t>(random % static_cast<std::uint64_t>(last - first)));
}

struct Area {
  int x0, y0, x1, y1;
};

// Chooses about `count_max` positions in a grid of cells over an area, or all positions if there are at most that many.
template <typename Take>
void for_each_position(const Area& area, int count_max, std::uint64_t seed, const Take& take) {
  const int width = area.x1 - area.x0, height = area.y1 - area.y0;
  const double step = std::max(1.0, std::sqrt(static_cast<double>(width) * height / count_max));
  const int columns = std::max(1, static_cast<int>(width / step)), rows = std::max(1, static_cast<int>(height / step));
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const std::uint64_t random = split_mix(seed + static_cast<std::uint64_t>(r) * 65536u + static_cast<unsigned>(c));
      take(position(c, columns, area.x0, area.x1, random & 0xffffffffu),
           position(r, rows, area.y0, area.y1, random >> 32));
    }
}

class Survey {
 public:
  Survey(const PlaneStore& normals, const SurveyedFeatures& features, const SurveySettings& settings)
      : normals_(normals), albedo_(features.albedo), weights_(features.weights), settings_(settings) {
    survey_.width = normals.width();
    survey_.height = normals.height();
    level_count_ = mip_level_count(survey_.width, survey_.height);
    band_level_ = std::min(kBandLevel, level_count_ - 1);
    pick_texels();
  }

  MapSurvey run() {
    const int bands = mip_level_size(survey_.height, band_level_);
    std::vector<Band> done(size_of(bands));
    for_each_item(bands, settings_.threads, [&](int b) { run_band(b, done[size_of(b)]); });
    std::vector<LevelSums> levels(size_of(level_count_));
    std::array<Range, 6> ranges;
    std::vector<NumberedRow> rows;
    for (Band& band : done) {
      for (std::size_t l = 0; l < band.levels.size(); ++l) levels[l].add(band.levels[l]);
      for (std::size_t r = 0; r < ranges.size(); ++r) ranges[r].add(band.ranges[r]);
      if (band.row) rows.push_back(std::move(*band.row));
    }
    for (int l = band_level_ + 1; l < level_count_; ++l) {
      rows = coarser(rows, l);
      for (const NumberedRow& row : rows) levels[size_of(l)].add(row.sums);
    }
    for (int l = 1; l < level_count_; ++l) {
      const LevelSums& s = levels[size_of(l)];
      survey_.levels.push_back({l, s.texels, s.spread / s.texels, s.spread_max,
                                s.variance > 0.0 ? std::min(s.difference / s.variance, 1.0) : 0.0});
    }
    survey_.normal_range = std::max(ranges[0].size(), ranges[1].size());
    survey_.z_min = ranges[2].low;
    if (albedo_ != nullptr)
      for (std::size_t c = 3; c < ranges.size(); ++c)
        survey_.colour_range = std::max(survey_.colour_range, ranges[c].size());
    return std::move(survey_);
  }

 private:
  struct Band {
    std::optional<NumberedRow> row;  // row of band_level_, if the band is summed
    std::vector<LevelSums> levels;
    std::array<Range, 6> ranges;  // ranges of x, y, z, red, green, blue
  };

  int width_of(int level) const { return mip_level_size(survey_.width, level); }
  int height_of(int level) const { return mip_level_size(survey_.height, level); }

  void pick_texels() {
    for (int l = 1; l < level_count_; ++l) {
      const auto seed = settings_.seed * 0x100000001b3u + static_cast<std::uint64_t>(l) * 0x10001u;
      for_each_position({0, 0, width_of(l), height_of(l)}, settings_.texels_per_level, seed, [&](int x, int y) {
        const auto begin = [](int i, int size, int of) { return static_cast<int>(std::int64_t{i} * of / size); };
        const Area area{begin(x, width_of(l), survey_.width), begin(y, height_of(l), survey_.height),
                        begin(x + 1, width_of(l), survey_.width), begin(y + 1, height_of(l), survey_.height)};
        const std::size_t texel = survey_.texels.size();
        std::size_t count = 0;
        for_each_position(area, settings_.normals_per_texel, seed + split_mix(texel), [&](int column, int row) {
          picks_.push_back({row, column, texel, count++});
        });
        survey_.texels.push_back({l, Normals(count), {}, {}});
        if (albedo_ != nullptr) survey_.texels.back().colours.resize(count);
        if (weights_ != nullptr) survey_.texels.back().weights.resize(count);
      });
    }
    std::stable_sort(picks_.begin(), picks_.end(), [](const Pick& a, const Pick& b) { return a.row < b.row; });
  }

  // Returns the first finest row that a row of band_level_ covers.
  int first_row(int band) const {
    const auto of = [&](int row) {
      for (int l = 1; l <= band_level_; ++l) row = parent_of(row, height_of(l - 1), height_of(l));
      return row;
    };
    int low = 0, high = survey_.height;
    while (low < high) {
      const int middle = low + (high - low) / 2;
      if (of(middle) < band) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  void run_band(int number, Band& band) {
    const int first = first_row(number), count = first_row(number + 1) - first;
    const std::size_t width = size_of(survey_.width);
    std::array<std::vector<float>, 3> n, c;
    const auto read = [&](const PlaneStore& store, std::array<std::vector<float>, 3>& planes) {
      for (std::vector<float>& plane : planes) plane.resize(width * size_of(count));
      store.read_rows(first, count, {planes[0].data(), planes[1].data(), planes[2].data()});
    };
    read(normals_, n);
    if (albedo_ != nullptr) read(*albedo_, c);
    take_picks(first, count, n, c);
    for (std::size_t r = 0; r < (albedo_ != nullptr ? 6 : 3); ++r) band.ranges[r].add(r < 3 ? n[r] : c[r - 3]);
    const bool is_large = std::int64_t{survey_.width} * survey_.height > kSummedTexels;
    if (is_large && number % kBandStride != 0) return;
    band.levels.resize(size_of(band_level_ + 1));
    std::vector<NumberedRow> rows;
    for (int y = 0; y < count; ++y) rows.push_back({first + y, finest_row(n, size_of(y) * width)});
    for (int l = 1; l <= band_level_; ++l) {
      rows = coarser(rows, l);
      for (const NumberedRow& row : rows) band.levels[size_of(l)].add(row.sums);
    }
    band.row = std::move(rows.front());
  }

  // Sums a single row for level 1, or for level 0 if that is the only level.
  SumRow finest_row(const std::array<std::vector<float>, 3>& n, std::size_t first) const {
    const int parents = level_count_ > 1 ? width_of(1) : 1;
    SumRow row(size_of(parents));
    for (int i = 0; i < survey_.width; ++i) {
      const auto x = static_cast<double>(n[0][first + size_of(i)]), y = static_cast<double>(n[1][first + size_of(i)]);
      Sums& to = row[size_of(parent_of(i, survey_.width, parents))];
      to.count += 1.0;
      to.x += x, to.y += y, to.z += static_cast<double>(n[2][first + size_of(i)]);
      to.xx += x * x, to.yy += y * y, to.xy += x * y;
    }
    return row;
  }

  // Makes rows of level l from rows of the next finer level, from the top. Rows of level 0 are passed in with their
  // columns already reduced to those of level 1.
  std::vector<NumberedRow> coarser(const std::vector<NumberedRow>& rows, int l) const {
    std::vector<NumberedRow> out;
    for (const NumberedRow& row : rows) {
      const int parent = parent_of(row.number, height_of(l - 1), height_of(l));
      if (out.empty() || out.back().number != parent) out.push_back({parent, SumRow(size_of(width_of(l)))});
      const int from = static_cast<int>(row.sums.size());
      for (int x = 0; x < from; ++x)
        out.back().sums[size_of(parent_of(x, from, width_of(l)))].add(row.sums[size_of(x)]);
    }
    return out;
  }

  // Bands write to different elements, so no lock is needed.
  void take_picks(int first, int count, const std::array<std::vector<float>, 3>& n,
                  const std::array<std::vector<float>, 3>& c) {
    auto pick =
        std::lower_bound(picks_.begin(), picks_.end(), first, [](const Pick& p, int row) { return p.row < row; });
    for (; pick != picks_.end() && pick->row < first + count; ++pick) {
      const std::size_t i = size_of(pick->row - first) * size_of(survey_.width) + size_of(pick->column);
      SurveyedTexel& texel = survey_.texels[pick->texel];
      texel.normals[pick->index] = {n[0][i], n[1][i], n[2][i]};
      if (albedo_ != nullptr) texel.colours[pick->index] = {c[0][i], c[1][i], c[2][i]};
      for (int w = 0; weights_ != nullptr && w < weights_->count; ++w)
        texel.weights[pick->index][w] =
            static_cast<double>(weights_->rgb_planes[size_of(w / 3)].texel(pick->column, pick->row)[size_of(w % 3)]);
    }
  }

  const PlaneStore& normals_;
  const PlaneStore* const albedo_;
  const WeightMap* const weights_;
  const SurveySettings settings_;
  MapSurvey survey_;
  int level_count_ = 1, band_level_ = 0;
  std::vector<Pick> picks_;  // sorted by rows
};

}  // namespace

MapSurvey survey_map(const PlaneStore& normals, const SurveyedFeatures& features, const SurveySettings& settings) {
  return Survey(normals, features, settings).run();
}

}  // namespace multum
