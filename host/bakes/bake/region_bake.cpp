// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/region_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/bakes/movmf/lobe_rows.h"
#include "host/bakes/pyramid/finest_rows.h"
#include "host/formats/image/surface_points.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

void check_same(const std::string& path, const char* what, const std::string& found, const std::string& expected) {
  if (found != expected)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found {} {}, expected {} as in this bake", path, what, found, expected));
}

std::string size_text(const MovmfMipmap& m) { return fmt::format("{} x {}", m.width(), m.height()); }

void check_old(const std::string& path, const MovmfMipmap& old, const MovmfMipmap& header) {
  check_same(path, "representation", representation_info(old.header.representation).name,
             representation_info(header.header.representation).name);
  check_same(path, "a map of", size_text(old), size_text(header));
  check_same(path, "lobes:", std::to_string(old.lobe_count()), std::to_string(header.lobe_count()));
  check_same(path, "encoding", storage_encoding_name(old.header.encoding),
             storage_encoding_name(header.header.encoding));
  check_same(path, "first level", std::to_string(old.header.first_level), std::to_string(header.header.first_level));
  check_same(path, "colours:", old.has_colours() ? "yes" : "no", header.has_colours() ? "yes" : "no");
  check_same(path, "weights:", std::to_string(old.header.weight_count), std::to_string(header.header.weight_count));
  check_same(path, "a mean cosine of", std::to_string(old.header.mean_cosine),
             std::to_string(header.header.mean_cosine));
  check_same(path, "roughness:", old.header.has_roughness ? "yes" : "no", header.header.has_roughness ? "yes" : "no");
  check_same(path, "wrap mode", wrap_mode_name(old.header.wrap_s), wrap_mode_name(header.header.wrap_s));
  check_same(path, "wrap mode", wrap_mode_name(old.header.wrap_t), wrap_mode_name(header.header.wrap_t));
}

void check_region(const MapRegion& region, const MovmfMipmap& header) {
  if (region.x < 0 || region.y < 0 || region.width < 1 || region.height < 1 ||
      region.width > header.width() - region.x || region.height > header.height() - region.y)
    throw Error(ErrorCode::kUsage,
                fmt::format("--region {},{},{},{} is not inside the map, expected x,y,width,height within {} x {}",
                            region.x, region.y, region.width, region.height, header.width(), header.height()));
  // Edits at such a border also change points on the other side of the border.
  const BakedHeader& is = header.header;
  const bool wraps_x = is.wrap_s == WrapMode::kPeriodic && (region.x == 0 || region.x + region.width == is.width),
             wraps_y = is.wrap_t == WrapMode::kPeriodic && (region.y == 0 || region.y + region.height == is.height);
  if (baked_surface(is) == map_surface_name(MapSurface::kInterpolated) && (wraps_x || wraps_y))
    throw Error(ErrorCode::kUsage,
                fmt::format("--region {},{},{},{} touches a border where the map repeats, which --surface interpolated "
                            "does not allow; expected a region away from such borders, or a bake of the whole map",
                            region.x, region.y, region.width, region.height));
}

// Returns the texels of a level along one axis that overlap [first, first + count) of the map, plus the halo.
std::pair<int, int> touched(int first, int count, int map_size, int level_size) {
  const auto texel = [&](std::int64_t map_texel) { return map_texel * level_size; };
  const int begin = static_cast<int>(texel(first) / map_size);
  const int end = static_cast<int>((texel(std::int64_t{first} + count) + map_size - 1) / map_size);
  return {std::max(0, begin - kRegionHalo), std::min(level_size, end + kRegionHalo)};
}

// Copies columns x0..x1 for any number of values per texel.
template <typename Value>
void copy_columns(const std::vector<Value>& from, std::vector<Value>& to, int width, int rows, int x0, int x1) {
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(from.size()) / (std::ptrdiff_t{width} * rows);
  for (std::ptrdiff_t y = 0; y < rows; ++y)
    std::copy(from.begin() + (y * width + x0) * stride, from.begin() + (y * width + x1) * stride,
              to.begin() + (y * width + x0) * stride);
}

std::string region_text(const MapRegion& region) {
  return fmt::format("{},{},{},{}", region.x, region.y, region.width, region.height);
}

bool contains(const MapRegion& outer, const MapRegion& inner) {
  return outer.x <= inner.x && outer.y <= inner.y && outer.x + outer.width >= inner.x + inner.width &&
         outer.y + outer.height >= inner.y + inner.height;
}

// True if any of the rows [begin, end) is read when the rows of `range` are fitted on this level or on the next finer
// level. On a repeating map, the first rows are neighbours of the last.
bool is_near(int begin, int end, const TexelRange& range, int height) {
  constexpr int kFar = 8;
  for (const int turn : {-height, 0, height})
    if (begin + turn < range.y1 + kFar && end + turn > range.y0 - kFar) return true;
  return false;
}

// Compares the stored values of a texel, whose lobes may be in a different order in each file. Ignores rounding
// differences between two encodings of the same map.
bool is_same_texel(const MovmfFinest& a, const MovmfFinest& b, std::size_t i) {
  constexpr float kNormalSteps = 2.0f / 32767.0f, kColourSteps = 2.0f / 2048.0f;
  const auto is_near = [](float x, float y, float steps) {
    return std::abs(x - y) <= steps * std::max({1e-3f, std::abs(x), std::abs(y)});
  };
  for (int c = 0; c < 3; ++c) {
    if (std::abs(a.normals[i][c] - b.normals[i][c]) > kNormalSteps && (c < 2 || a.has_roughness)) return false;
    if (!a.colours.empty() && !is_near(a.colours[i][c], b.colours[i][c], kColourSteps)) return false;
  }
  const std::size_t weights = a.weight_count();
  for (std::size_t k = i * weights; k < (i + 1) * weights; ++k)
    if (!is_near(a.weights[k], b.weights[k], kColourSteps)) return false;
  return true;
}

}  // namespace

std::optional<MapRegion> find_changed_region(const std::string& old, const MovmfMipmap& header,
                                             const PlaneStore& normals, const FeaturePlanes& features, int threads) {
  MovmfReader reader(old, threads);
  check_old(old, reader.header(), header);
  if (header.header.first_level > 0) return std::nullopt;
  int x0 = header.width(), x1 = 0, y0 = header.height(), y1 = 0;
  for (int row = 0; row < header.height(); row += reader.tile_size()) {
    const int count = std::min(reader.tile_size(), header.height() - row);
    const MovmfFinest stored = reader.read_finest(row, count);
    MovmfFinest made = finest_rows(normals, features, header.header.representation, row, count, threads);
    quantize_movmf(made, header.header.encoding, threads);
    std::size_t i = 0;
    for (int y = row; y < row + count; ++y)
      for (int x = 0; x < header.width(); ++x, ++i) {
        if (is_same_texel(stored, made, i)) continue;
        x0 = std::min(x0, x);
        x1 = std::max(x1, x + 1);
        y0 = std::min(y0, y);
        y1 = y + 1;
      }
  }
  return x1 > x0 ? MapRegion{x0, y0, x1 - x0, y1 - y0} : MapRegion{};
}

MapRegion resolve_region(const std::optional<MapRegion>& asked, const std::string& input, const std::string& old,
                         const MovmfMipmap& header, const PlaneStore& normals, const FeaturePlanes& features,
                         int threads) {
  if (asked) check_region(*asked, header);
  const std::optional<MapRegion> changed = find_changed_region(old, header, normals, features, threads);
  if (!changed && !asked)
    throw Error(ErrorCode::kUsage,
                old + ": does not store level 0, so changes cannot be detected; expected --region x,y,width,height");
  if (!changed) {
    log_warning(input, fmt::format("{} does not store level 0, so changes outside --region {} cannot be detected", old,
                                   region_text(*asked)));
    return *asked;
  }
  if (changed->height == 0) log_info(fmt::format("{}: no texel has changed since {} was baked", input, old));
  else log_info(fmt::format("{}: since {} was baked, this part has changed: {}", input, old, region_text(*changed)));
  if (!asked) return changed->height == 0 ? MapRegion{0, 0, 1, 1} : *changed;
  if (changed->height > 0 && !contains(*asked, *changed))
    throw Error(ErrorCode::kInput, fmt::format("{}: since {} was baked, the part {} has changed; expected no changes "
                                               "outside --region {}. --region auto bakes the changed part",
                                               input, old, region_text(*changed), region_text(*asked)));
  return *asked;
}

RegionBake::RegionBake(const std::string& old, const MovmfMipmap& header, const MapRegion& region,
                       const SpillPolicy& spill, BakeOutput& output)
    : RowOrigin(this, spill),
      old_(old),
      header_(header),
      region_(region),
      output_(output),
      next_row_(header.levels.size(), 0) {
  check_old(old, old_.header(), header);
  // The surface is one of the settings, which are not yet in the header while the program searches for changes.
  check_same(old, "a surface of", baked_surface(old_.header().header), baked_surface(header.header));
  check_region(region, header);
}

TexelRange RegionBake::texels(int level) const {
  const MovmfLevel& size = header_.levels[static_cast<std::size_t>(level)];
  const auto [x0, x1] = touched(region_.x, region_.width, header_.width(), size.width);
  const auto [y0, y1] = touched(region_.y, region_.height, header_.height(), size.height);
  return {x0, y0, x1, y1};
}

LevelTask RegionBake::begin(const LevelShape& level) {
  start_from(old_lobes(level.level));
  return RowOrigin::begin(level);
}

// Restores the old values of fitted rows outside the region.
void RegionBake::end() {
  const TexelRange where = texels(level_.level);
  std::vector<unsigned char> row(level_.lobe_row_bytes);
  for (int y = where.y0; own_ && y < where.y1; ++y) {
    own_->read(y, 1, row.data());
    before_->write(y, 1, row.data());
  }
  own_ = std::move(before_);
  RowOrigin::end();
}

RowStore RegionBake::old_lobes(int level) const {
  const MovmfLevel& size = header_.levels[static_cast<std::size_t>(level)];
  const auto width = static_cast<std::size_t>(size.width);
  const std::size_t lobes = size.lobes.size();
  RowStore store(size.height, lobes * width * sizeof(MultumVmfLobe), spill_);
  std::vector<MultumVmfLobe> rows(lobes * width);
  store.write(size.height - 1, 1, rows.data());  // gives the file its full length; rows that are not read remain zero
  const TexelRange where = texels(level);
  for (int first = 0; first < size.height; first += old_.tile_size()) {
    if (!is_near(first, first + old_.tile_size(), where, size.height)) continue;
    const MovmfLevel stored = old_.read_level(level, first, std::min(old_.tile_size(), size.height - first));
    rows.resize(static_cast<std::size_t>(stored.height) * lobes * width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(stored.height); ++y)
      for (std::size_t j = 0; j < lobes; ++j)
        for (std::size_t x = 0; x < width; ++x) {
          rows[(y * lobes + j) * width + x] =
              fitted_lobe(stored.lobes[j][y * width + x], header_.header.representation);
        }
    store.write(first, stored.height, rows.data());
  }
  return store;
}

void RegionBake::write_level(int level, int first_row, MovmfLevel rows) {
  next_row_[static_cast<std::size_t>(level)] = first_row + rows.height;
  output_.write(level, first_row, std::move(rows));
}

void RegionBake::write_finest(int first_row, MovmfFinest rows) {
  next_row_[0] = first_row + rows.height;
  output_.write(first_row, std::move(rows));
}

void RegionBake::copy_level_until(int level, int row) {
  for (int& next = next_row_[static_cast<std::size_t>(level)]; next < row;) {
    const int count = std::min(row, next + old_.tile_size() - next % old_.tile_size()) - next;
    write_level(level, next, old_.read_level(level, next, count));
  }
}

void RegionBake::copy_finest_until(int row) {
  while (next_row_[0] < row) {
    const int next = next_row_[0];
    const int count = std::min(row, next + old_.tile_size() - next % old_.tile_size()) - next;
    write_finest(next, old_.read_finest(next, count));
  }
}

void RegionBake::add_level(int level, int first_row, MovmfLevel rows) {
  copy_level_until(level, first_row);
  output_.round(rows);
  MovmfLevel merged = old_.read_level(level, first_row, rows.height);
  const TexelRange where = texels(level);
  for (std::size_t j = 0; j < rows.lobes.size(); ++j)
    copy_columns(rows.lobes[j], merged.lobes[j], rows.width, rows.height, where.x0, where.x1);
  for (std::size_t j = 0; j < rows.colours.size(); ++j)
    copy_columns(rows.colours[j], merged.colours[j], rows.width, rows.height, where.x0, where.x1);
  for (std::size_t j = 0; j < rows.weights.size(); ++j)
    copy_columns(rows.weights[j], merged.weights[j], rows.width, rows.height, where.x0, where.x1);
  write_level(level, first_row, std::move(merged));
}

void RegionBake::add_finest(int first_row, MovmfFinest rows) {
  copy_finest_until(first_row);
  output_.round(rows);
  MovmfFinest merged = old_.read_finest(first_row, rows.height);
  // The texels that newly fitted parents cover. The order of the lobes of these parents may have changed.
  TexelRange where = header_.levels.size() > 1 ? texels(1) : texels(0);
  const bool to_the_end = header_.levels.size() == 1 || where.x1 == header_.levels[1].width;
  const int x0 = header_.levels.size() > 1 ? 2 * where.x0 : 0, x1 = to_the_end ? header_.width() : 2 * where.x1;
  copy_columns(rows.normals, merged.normals, rows.width, rows.height, x0, x1);
  copy_columns(rows.lobe, merged.lobe, rows.width, rows.height, x0, x1);
  copy_columns(rows.colours, merged.colours, rows.width, rows.height, x0, x1);
  copy_columns(rows.weights, merged.weights, rows.width, rows.height, x0, x1);
  write_finest(first_row, std::move(merged));
}

void RegionBake::finish() {
  for (int level = std::max(1, header_.header.first_level); level < static_cast<int>(header_.levels.size()); ++level)
    copy_level_until(level, header_.levels[static_cast<std::size_t>(level)].height);
  if (header_.header.first_level == 0) copy_finest_until(header_.height());
}

}  // namespace multum
