// SPDX-License-Identifier: Apache-2.0
#include "host/bake/moment_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "host/bake/feature_planes.h"
#include "host/bake/row_blocks.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "kernels/shared/moments.h"

namespace multum {
namespace {

// More makes nothing faster. Averaging a map of 4096 x 4096 on 2 cores of an AMD EPYC takes 3.6 s in bands of 16
// MiB, 3.9 s in bands of 64 MiB and 4.5 s in bands of 2 MiB (PoCL 3.1, medians of three, beside other work).
constexpr std::uint64_t kUsefulBandBytes = std::uint64_t{16} << 20;
constexpr int kSideMax = 32768;  // products of two sides fit an int
constexpr std::size_t kMapPlanes = 3;

// Work-items are small: PoCL takes as long to begin a group of them as to run one.
constexpr std::size_t kLocalSize = 64;

std::size_t size_of(int count) { return static_cast<std::size_t>(count); }

// The columns of all levels that are averaged, and what each takes of a row.
struct Columns {
  std::vector<MultumMomentLevel> levels;
  std::vector<int> numbers;  // of these levels
  std::vector<int> tap_begin;
  std::vector<MultumMomentTap> taps;
};

Columns make_columns(const RowBlocks& blocks, int map_width, int map_height, int first_level) {
  Columns columns;
  std::vector<RowBlocks::Tap> taps;
  for (int l = std::max(1, first_level); l < mip_level_count(map_width, map_height); ++l) {
    MultumMomentLevel level{};
    level.width = mip_level_size(map_width, l);
    level.height = mip_level_size(map_height, l);
    level.first_column = static_cast<int>(columns.tap_begin.size());
    level.share = static_cast<float>(static_cast<double>(level.width) * level.height /
                                     (static_cast<double>(map_width) * map_height));
    for (int x = 0; x < level.width; ++x) {
      columns.tap_begin.push_back(static_cast<int>(columns.taps.size()));
      taps.clear();
      blocks.append_taps(level.width, x, taps);
      for (const RowBlocks::Tap& tap : taps)
        columns.taps.push_back({static_cast<int>(tap.node), static_cast<float>(tap.weight)});
    }
    columns.levels.push_back(level);
    columns.numbers.push_back(l);
  }
  columns.tap_begin.push_back(static_cast<int>(columns.taps.size()));
  return columns;
}

// Rows of planes lie one plane after another, `plane_size` values apart, `row_length` from row to row.
struct PlaneRows {
  const float* first;
  std::size_t plane_size, row_length;
};

MomentLevel gather(const PlaneRows& from, int width, int height, const FeaturePlanes& features, int threads) {
  MomentLevel rows{width, height, {}, {}, {}};
  const std::size_t texels = size_of(width) * size_of(height);
  rows.slopes.resize(texels);
  rows.normals.resize(texels);
  std::vector<std::vector<glm::vec3>> triples(features.triples.size(), std::vector<glm::vec3>(texels));
  for_each_row_band(height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (int y = row_begin; y < row_end; ++y) {
      const float* const in = from.first + size_of(y) * from.row_length;
      const auto value = [&](int plane, std::size_t x) { return in[size_of(plane) * from.plane_size + x]; };
      for (std::size_t x = 0; x < size_of(width); ++x) {
        const std::size_t i = size_of(y) * size_of(width) + x;
        rows.slopes[i] = {kNoHeight,
                          value(MULTUM_MOMENT_S, x),
                          value(MULTUM_MOMENT_T, x),
                          value(MULTUM_MOMENT_SS, x),
                          value(MULTUM_MOMENT_TT, x),
                          value(MULTUM_MOMENT_ST, x)};
        const auto vector = [&](int plane) {
          return glm::vec3(value(plane, x), value(plane + 1, x), value(plane + 2, x));
        };
        rows.normals[i] = vector(MULTUM_MOMENT_NORMAL);
        for (std::size_t t = 0; t < triples.size(); ++t)
          triples[t][i] = vector(MULTUM_MOMENT_PLANES + 3 * static_cast<int>(t));
      }
    }
  });
  split_features(std::move(triples), features, rows.colours, rows.weights);
  return rows;
}

class MomentPass {
 public:
  MomentPass(Device& device, const MomentBakeInputs& inputs, MomentSink& sink)
      : device_(device),
        inputs_(inputs),
        sink_(sink),
        width_(inputs.normals->width()),
        height_(inputs.normals->height()),
        feature_planes_(FeaturePlanes::of(inputs.albedo, inputs.weights)),
        plane_count_(MULTUM_MOMENT_PLANES + 3 * feature_planes_.triple_count()),
        blocks_(width_),
        columns_(make_columns(blocks_, width_, height_, inputs.first_level)),
        band_rows_(choose_band_rows()) {
    make_buffers();
    finest_ = device.kernel("moments", "moment_finest", {1, 1, false});
    take_features_ = device.kernel("moments", "moment_features", {1, 1, false});
    sum_blocks_ = device.kernel("moments", "moment_blocks", {1, 1, false});
    sum_levels_ = device.kernel("moments", "moment_levels", {1, 1, false});
  }

  std::string plan_text() const {
    return fmt::format("moments of {} x {}: one pass in bands of {} rows, {:.1f} MiB of buffers\n", width_, height_,
                       band_rows_, static_cast<double>(fixed_bytes() + size_of(band_rows_) * row_bytes()) / (1u << 20));
  }

  /// Returns how many normals are nearer to the horizon than slopes go.
  std::uint64_t run(Progress* progress) {
    progress_stage(progress, "average");
    for (int row = 0; row < height_; row += band_rows_) {
      const int rows = std::min(band_rows_, height_ - row);
      read_band(row, rows);
      average(row, rows);
      hand_over(row, rows);
      progress_advance(progress, static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(width_));
    }
    return clamped_;
  }

 private:
  // Nodes of a row apart: rounded up, and not at a distance of a power of two, which would share cache lines' places.
  int row_length() const { return static_cast<int>((blocks_.node_count() + 15) / 16 * 16 + 16); }
  int column_count() const { return static_cast<int>(columns_.tap_begin.size()) - 1; }

  // The rows of a level that `rows` finest rows finish, at most.
  int finished_max(const MultumMomentLevel& level, int rows) const {
    return static_cast<int>(std::int64_t{rows} * level.height / height_) + 1;
  }
  // What a row more in the bands takes: map planes, nodes, what comes of them, and rows that wait to be written.
  std::uint64_t row_bytes() const {
    const std::size_t map_planes = kMapPlanes * (1 + feature_planes_.triples.size());
    const std::size_t values = map_planes * size_of(width_) + size_of(plane_count_) * size_of(row_length()) +
                               3 * size_of(plane_count_ + 1) * size_of(width_);
    return values * sizeof(float);
  }
  std::uint64_t fixed_bytes() const {
    const std::size_t columns = size_of(column_count()), planes = size_of(plane_count_);
    // A row of every level whatever the band's height, twice: as averages and as rows that are handed over.
    return columns * planes * 4 * sizeof(float) + columns * sizeof(int) +
           columns_.taps.size() * sizeof(MultumMomentTap);
  }
  int choose_band_rows() const {
    if (fixed_bytes() + row_bytes() > inputs_.memory_bytes)
      throw Error(ErrorCode::kUsage,
                  fmt::format("--memory leaves {} KiB for buffers, expected at least {} KiB: a row of a map of {} x {}",
                              inputs_.memory_bytes >> 10, ((fixed_bytes() + row_bytes()) >> 10) + 1, width_, height_));
    const std::uint64_t bytes = std::min(kUsefulBandBytes, inputs_.memory_bytes - fixed_bytes());
    return static_cast<int>(std::clamp<std::uint64_t>(bytes / row_bytes(), 1, static_cast<std::uint64_t>(height_)));
  }

  void make_buffers() {
    const std::size_t row = size_of(width_) * sizeof(float) * size_of(band_rows_);
    for (DeviceBuffer& plane : normals_) plane = device_.make_buffer(row, "normals");
    features_.resize(feature_planes_.triples.size());
    for (std::array<DeviceBuffer, kMapPlanes>& triple : features_)
      for (DeviceBuffer& plane : triple) plane = device_.make_buffer(row, "features");
    nodes_ = device_.make_buffer(size_of(plane_count_) * size_of(band_rows_) * size_of(row_length()) * sizeof(float),
                                 "nodes of rows");
    std::size_t values = 1;
    for (const MultumMomentLevel& level : columns_.levels)
      values += size_of(plane_count_) * size_of(finished_max(level, band_rows_)) * size_of(level.width);
    averages_ = device_.make_buffer(values * sizeof(float), "averages");
    sums_ = device_.make_buffer(
        std::max<std::size_t>(1, size_of(plane_count_) * size_of(column_count())) * 2 * sizeof(float),
        "sums of columns");
    device_.fill_zero(sums_);
    if (columns_.levels.empty()) return;
    tap_begin_ = device_.wrap_buffer(columns_.tap_begin.data(), columns_.tap_begin.size() * sizeof(int), "taps");
    taps_ = device_.wrap_buffer(columns_.taps.data(), columns_.taps.size() * sizeof(MultumMomentTap), "taps");
    levels_ = device_.make_buffer(columns_.levels.size() * sizeof(MultumMomentLevel), "levels");
  }

  void read_band(int first_row, int rows) {
    const auto read = [&](const PlaneStore& store, std::array<DeviceBuffer, kMapPlanes>& planes) {
      for (int p = 0; p < static_cast<int>(kMapPlanes); ++p)
        device_.visit(planes[size_of(p)],
                      [&](void* bytes) { store.read_rows(p, first_row, rows, static_cast<float*>(bytes)); });
    };
    read(*inputs_.normals, normals_);
    for (std::size_t t = 0; t < features_.size(); ++t) read(*feature_planes_.triples[t], features_[t]);
    count_clamped(rows);
  }

  // Normals that are nearer to the horizon than slopes go, whatever their length.
  void count_clamped(int rows) {
    std::array<const float*, kMapPlanes> n{};
    for (std::size_t p = 0; p < kMapPlanes; ++p)
      device_.visit(normals_[p], [&](void* bytes) { n[p] = static_cast<const float*>(bytes); });
    for (std::size_t i = 0; i < size_of(rows) * size_of(width_); ++i) {
      const float length =
          inputs_.has_roughness ? std::sqrt(n[0][i] * n[0][i] + n[1][i] * n[1][i] + n[2][i] * n[2][i]) : 1.0f;
      clamped_ += n[2][i] < kSlopeZMin * length ? 1u : 0u;
    }
  }

  MultumMomentBand band_of(int first_row, int rows) const {
    MultumMomentBand band{};
    band.map_width = width_;
    band.map_height = height_;
    band.first_row = first_row;
    band.row_count = rows;
    band.row_length = row_length();
    band.plane_count = plane_count_;
    band.level_count = static_cast<int>(columns_.levels.size());
    band.column_count = column_count();
    band.slope_z_min = kSlopeZMin;
    band.shortened = inputs_.has_roughness ? 1 : 0;
    return band;
  }

  void average(int first_row, int rows) {
    const MultumMomentBand band = band_of(first_row, rows);
    const Kernel::WorkSize texels = {size_of(rows) * size_of(width_), kLocalSize};
    finest_.launch(texels, normals_[0], normals_[1], normals_[2], nodes_, band);
    int first_plane = MULTUM_MOMENT_PLANES;
    for (const std::array<DeviceBuffer, kMapPlanes>& triple : features_) {
      take_features_.launch(texels, triple[0], triple[1], triple[2], nodes_, band, first_plane);
      first_plane += 3;
    }
    if (columns_.levels.empty()) return;
    for (int k = 1; k < blocks_.depth(); ++k)
      sum_blocks_.launch({size_of(plane_count_) * size_of(rows) * size_of(blocks_.block_count(k)), kLocalSize}, nodes_,
                         band, static_cast<int>(blocks_.block_begin(k - 1)), static_cast<int>(blocks_.block_begin(k)),
                         blocks_.block_count(k));
    int first_value = 0;
    for (MultumMomentLevel& level : columns_.levels) {
      const auto row_at = [&](int finest) { return static_cast<int>(std::int64_t{finest} * level.height / height_); };
      level.first_row = row_at(first_row);
      level.row_count = row_at(first_row + rows) - level.first_row;
      level.first_value = first_value;
      first_value += plane_count_ * level.row_count * level.width;
    }
    device_.write(levels_, columns_.levels.data(), columns_.levels.size() * sizeof(MultumMomentLevel));
    sum_levels_.launch({size_of(plane_count_) * size_of(column_count()), kLocalSize}, nodes_, levels_, tap_begin_,
                       taps_, sums_, averages_, band);
  }

  void hand_over(int first_row, int rows) {
    if (inputs_.first_level == 0)
      device_.visit(nodes_, [&](void* bytes) {
        const PlaneRows from = {static_cast<const float*>(bytes), size_of(rows) * size_of(row_length()),
                                size_of(row_length())};
        sink_.add_level(0, first_row, gather(from, width_, rows, feature_planes_, inputs_.threads));
      });
    if (columns_.levels.empty()) return;
    device_.visit(averages_, [&](void* bytes) {
      for (std::size_t i = 0; i < columns_.levels.size(); ++i) {
        const MultumMomentLevel& level = columns_.levels[i];
        if (level.row_count == 0) continue;
        const PlaneRows from = {static_cast<const float*>(bytes) + level.first_value,
                                size_of(level.row_count) * size_of(level.width), size_of(level.width)};
        sink_.add_level(columns_.numbers[i], level.first_row,
                        gather(from, level.width, level.row_count, feature_planes_, inputs_.threads));
      }
    });
  }

  Device& device_;
  const MomentBakeInputs& inputs_;
  MomentSink& sink_;
  const int width_, height_;
  const FeaturePlanes feature_planes_;
  const int plane_count_;
  const RowBlocks blocks_;
  Columns columns_;
  const int band_rows_;
  std::uint64_t clamped_ = 0;
  std::array<DeviceBuffer, kMapPlanes> normals_;
  std::vector<std::array<DeviceBuffer, kMapPlanes>> features_;  // triples
  DeviceBuffer nodes_, averages_, sums_, tap_begin_, taps_, levels_;
  Kernel finest_, take_features_, sum_blocks_, sum_levels_;
};

// Gathers what a bake hands over into a whole mipmap.
class MipmapSink : public MomentSink {
 public:
  explicit MipmapSink(std::vector<MomentLevel>& levels) : levels_(levels) {}
  void add_level(int level, int, MomentLevel rows) override {
    MomentLevel& to = levels_[size_of(level)];
    to.slopes.insert(to.slopes.end(), rows.slopes.begin(), rows.slopes.end());
    to.normals.insert(to.normals.end(), rows.normals.begin(), rows.normals.end());
    to.colours.insert(to.colours.end(), rows.colours.begin(), rows.colours.end());
    to.weights.insert(to.weights.end(), rows.weights.begin(), rows.weights.end());
  }

 private:
  std::vector<MomentLevel>& levels_;
};

}  // namespace

void validate_moments(int first_level, int map_width, int map_height) {
  if (map_width > kSideMax || map_height > kSideMax)
    throw Error(ErrorCode::kInput, fmt::format("found a map of {} x {}, expected at most {} texels a side", map_width,
                                               map_height, kSideMax));
  const int level_max = mip_level_count(map_width, map_height) - 1;
  if (first_level < 0 || first_level > level_max)
    throw Error(ErrorCode::kUsage, fmt::format("--first-level is {}, expected 0 to {}, the levels of a map of {} x {}",
                                               first_level, level_max, map_width, map_height));
}

void bake_moments(Device& device, const MomentBakeInputs& inputs, MomentSink& sink, BakeReport& report,
                  Progress* progress) {
  const PlaneStore& normals = *inputs.normals;
  validate_moments(inputs.first_level, normals.width(), normals.height());
  MULTUM_CHECK(FeaturePlanes::of(inputs.albedo, inputs.weights).all_of_size(normals.width(), normals.height()));
  MomentPass pass(device, inputs, sink);
  report.plan = pass.plan_text();
  report.device = device.info().name;
  report.slopes_limited = pass.run(progress);
}

MomentMipmap bake_moments(Device& device, const NormalMap& map, const ColourMap* albedo, const MomentBakeInputs& inputs,
                          BakeReport& report, Progress* progress) {
  const PlaneStore normals = planes_of(map);
  std::optional<PlaneStore> colours;
  if (albedo != nullptr) colours = planes_of(*albedo);
  MomentBakeInputs all = inputs;
  all.normals = &normals;
  all.albedo = colours ? &*colours : nullptr;
  MomentMipmap mipmap;
  mipmap.header.representation = Representation::kMoments;
  mipmap.header.encoding = StorageEncoding::kFloat;
  mipmap.header.width = map.width;
  mipmap.header.height = map.height;
  mipmap.header.first_level = inputs.first_level;
  mipmap.header.has_colours = albedo != nullptr;
  mipmap.header.weight_count = inputs.weights != nullptr ? inputs.weights->count : 0;
  mipmap.header.has_roughness = inputs.has_roughness;
  mipmap.levels = empty_moment_levels(map.width, map.height);
  MipmapSink sink(mipmap.levels);
  bake_moments(device, all, sink, report, progress);
  return mipmap;
}

}  // namespace multum
