// SPDX-License-Identifier: Apache-2.0
#include "host/api/api_map.h"

#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include "host/api/api_call.h"
#include "host/api/api_error.h"
#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

// Appends the floats of one layer.
template <typename Texel>
void append(const std::vector<Texel>& layer, std::vector<float>& values) {
  static_assert(sizeof(Texel) % sizeof(float) == 0);
  const std::size_t begin = values.size(), count = layer.size() * (sizeof(Texel) / sizeof(float));
  values.resize(begin + count);
  if (count > 0) std::memcpy(values.data() + begin, layer.data(), count * sizeof(float));
}

template <typename Texel>
void append_layers(const std::vector<std::vector<Texel>>& layers, std::vector<float>& values) {
  std::size_t count = 0;
  for (const auto& layer : layers) count += layer.size() * (sizeof(Texel) / sizeof(float));
  values.reserve(count);
  for (const auto& layer : layers) append(layer, values);
}

class LobeRows : public MapRows {
 public:
  LobeRows(const std::string& path, int threads) : reader_(path, threads) {}
  PartValues read(int level, int first_row, int row_count) override {
    const MovmfLevel rows = reader_.read_level(level, first_row, row_count);
    PartValues values;
    append_layers(rows.lobes, values[MULTUM_LOBES]);
    append_layers(rows.colours, values[MULTUM_COLOURS]);
    append_layers(rows.weights, values[MULTUM_WEIGHTS]);
    return values;
  }
  const BakedHeader& header() const override { return reader_.header().header; }
  int lobe_count() const override { return reader_.header().lobe_count(); }

 private:
  MovmfReader reader_;
};

class MomentRows : public MapRows {
 public:
  MomentRows(const std::string& path, int threads) : reader_(path, threads) {}
  PartValues read(int level, int first_row, int row_count) override {
    const MomentLevel rows = reader_.read_level(level, first_row, row_count);
    PartValues values;
    append(rows.slopes, values[MULTUM_SLOPES]);
    append(rows.normals, values[MULTUM_MEAN_NORMALS]);
    append(rows.colours, values[MULTUM_COLOURS]);
    append(rows.weights, values[MULTUM_WEIGHTS]);
    return values;
  }

  const BakedHeader& header() const override { return reader_.header(); }

 private:
  MomentReader reader_;
};

class HarmonicRows : public MapRows {
 public:
  HarmonicRows(const std::string& path, int threads) : reader_(path, threads) {}
  PartValues read(int level, int first_row, int row_count) override {
    const ShLevel rows = reader_.read_level(level, first_row, row_count);
    PartValues values;
    append_layers(rows.parts, values[MULTUM_HARMONICS]);
    append(rows.colours, values[MULTUM_COLOURS]);
    append(rows.weights, values[MULTUM_WEIGHTS]);
    return values;
  }

  const BakedHeader& header() const override { return reader_.header(); }
  int sh_order() const override { return reader_.order(); }

 private:
  ShReader reader_;
};

std::unique_ptr<MapRows> open_rows(const std::string& path, Representation representation) {
  const int threads = processor_count();
  switch (representation) {
    case Representation::kMovmf:
    case Representation::kGmm: return std::make_unique<LobeRows>(path, threads);
    case Representation::kMoments: return std::make_unique<MomentRows>(path, threads);
    case Representation::kSh: return std::make_unique<HarmonicRows>(path, threads);
  }
  MULTUM_CHECK(false);
}

void check_part(multum_part part) {
  if (part < MULTUM_LOBES || part > MULTUM_HARMONICS)
    throw Error(ErrorCode::kUsage, fmt::format("part is {}, expected a value of multum_part", static_cast<int>(part)));
}

constexpr const char* kPartNames[kMapParts] = {"lobes", "colours", "weights", "slopes", "mean normals", "harmonics"};

std::size_t type_bytes(multum_type type) { return type == MULTUM_FLOAT ? sizeof(float) : sizeof(std::uint16_t); }

void store_row(const float* from, std::size_t count, multum_type type, unsigned char* to) {
  if (type == MULTUM_FLOAT) {
    std::memcpy(to, from, count * sizeof(float));
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::uint16_t bits;
    if (type == MULTUM_HALF) bits = static_cast<std::uint16_t>(half(from[i]).bits());
    else bits = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(from[i] * 32767.0f)));
    std::memcpy(to + i * sizeof(bits), &bits, sizeof(bits));
  }
}

void check_type(multum_type type, const BakedHeader& header, multum_part part) {
  if (type == MULTUM_FLOAT || type == MULTUM_HALF) return;
  if (type != MULTUM_SNORM16)
    throw Error(ErrorCode::kUsage, fmt::format("type is {}, expected MULTUM_FLOAT, MULTUM_HALF or MULTUM_SNORM16",
                                               static_cast<int>(type)));
  if (part != MULTUM_LOBES || header.encoding != StorageEncoding::kSnorm16)
    throw Error(ErrorCode::kUsage,
                fmt::format("type is MULTUM_SNORM16 for {} of encoding {}, expected MULTUM_FLOAT or MULTUM_HALF",
                            kPartNames[part], storage_encoding_name(header.encoding)));
}

}  // namespace
}  // namespace multum

using multum::Error;
using multum::ErrorCode;
using multum::guarded;
using multum::mip_level_size;
using multum::PartValues;

multum_map::multum_map(std::string path, std::shared_ptr<void> folder)
    : folder_(std::move(folder)),
      path_(std::filesystem::absolute(path).string()),
      file_(path_),
      rows_(multum::open_rows(path_, multum::read_baked_header(path_).representation)),
      header_(rows_->header()),
      lobe_count_(rows_->lobe_count()),
      sh_order_(rows_->sh_order()),
      sh_layers_((sh_order_ * (sh_order_ + 2) + 3) / 4) {  // without the constant Y_00
  made_.resize(static_cast<std::size_t>(header_.level_count()));
  levels_ = std::vector<std::atomic<const PartValues*>>(made_.size());
  const multum::BakedProvenance& from = header_.provenance;
  add_text("representation", multum::representation_info(header_.representation).option);
  add_text("encoding", multum::storage_encoding_name(header_.encoding));
  add_text("content_hash", from.content_hash);
  add_text("source_name", from.source_name);
  add_text("source_hash", from.source_hash);
  add_text("settings", from.settings);
  add_text("measured_error", from.measured_error);
  add_text("reading", from.reading);
  add_text("software", from.software);
}

multum_info multum_map::info() const {
  const auto repeats = [](multum::WrapMode mode) { return mode == multum::WrapMode::kPeriodic ? 1 : 0; };
  return {header_.width,
          header_.height,
          header_.level_count(),
          header_.first_level,
          lobe_count_,
          sh_order_,
          header_.has_colours ? 1 : 0,
          header_.weight_count,
          repeats(header_.wrap_s),
          repeats(header_.wrap_t)};
}

multum::PartShape multum_map::shape(multum_part part) const {
  const int layers = lobe_count_ > 0 ? lobe_count_ : 1;
  const bool has_moments = header_.representation == multum::Representation::kMoments;
  switch (part) {
    case MULTUM_LOBES: return lobe_count_ > 0 ? multum::PartShape{lobe_count_, 4} : multum::PartShape{};
    case MULTUM_COLOURS: return header_.has_colours ? multum::PartShape{layers, 3} : multum::PartShape{};
    case MULTUM_WEIGHTS:
      return header_.weight_count > 0 ? multum::PartShape{layers, header_.weight_count} : multum::PartShape{};
    case MULTUM_SLOPES: return has_moments ? multum::PartShape{1, 6} : multum::PartShape{};
    case MULTUM_MEAN_NORMALS: return has_moments ? multum::PartShape{1, 3} : multum::PartShape{};
    case MULTUM_HARMONICS: return sh_order_ > 0 ? multum::PartShape{sh_layers_, 4} : multum::PartShape{};
  }
  return {};
}

void multum_map::check_level(int level) const {
  if (level < header_.first_level || level >= header_.level_count())
    throw Error(ErrorCode::kUsage, fmt::format("level is {}, expected {} to {}, the stored levels of {}", level,
                                               header_.first_level, header_.level_count() - 1, path_));
}

PartValues multum_map::checked(PartValues values, int level, int row_count) const {
  for (std::size_t part = 0; part < values.size(); ++part) {
    const multum::PartShape expected = shape(static_cast<multum_part>(part));
    const std::size_t texels =
        static_cast<std::size_t>(mip_level_size(header_.width, level)) * static_cast<std::size_t>(row_count);
    MULTUM_CHECK(values[part].size() ==
                 texels * static_cast<std::size_t>(expected.layers) * static_cast<std::size_t>(expected.channels));
  }
  return values;
}

const PartValues& multum_map::level(int level) {
  check_level(level);
  const auto index = static_cast<std::size_t>(level);
  if (const PartValues* made = levels_[index].load(std::memory_order_acquire)) return *made;
  const std::lock_guard lock(mutex_);
  if (made_[index] == nullptr) {
    const int rows = mip_level_size(header_.height, level);
    made_[index] = std::make_unique<PartValues>(checked(rows_->read(level, 0, rows), level, rows));
    levels_[index].store(made_[index].get(), std::memory_order_release);
  }
  return *made_[index];
}

PartValues multum_map::read(int level, int first_row, int row_count) {
  const std::lock_guard lock(mutex_);
  return checked(rows_->read(level, first_row, row_count), level, row_count);
}

void multum_map::forget() {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < made_.size(); ++i) {
    levels_[i].store(nullptr);
    made_[i].reset();
  }
}

const char* multum_map::text(const std::string& key) const {
  const auto found = texts_.find(key);
  return found == texts_.end() ? "" : found->second.c_str();
}

void multum_map::set_report(std::string report) { texts_["report"] = std::move(report); }

multum_status multum_map_open(const char* path, multum_map** map, multum_error** error) {
  return guarded(error, [&] {
    multum::require(path, "multum_map_open", "path", "the name of a baked file");
    multum::require(map, "multum_map_open", "map", "a place for the result");
    const multum::ApiCall call(nullptr);
    *map = new multum_map(path, nullptr);
  });
}

void multum_map_free(multum_map* map) { delete map; }

multum_info multum_map_info(const multum_map* map) { return map == nullptr ? multum_info{} : map->info(); }

const char* multum_map_text(multum_map* map, const char* key) {
  const char* text = "";
  if (map != nullptr && key != nullptr) guarded(nullptr, [&] { text = map->text(key); });
  return text;
}

multum_view multum_map_shape(const multum_map* map, int level, multum_part part) {
  multum_view view = {};
  if (map == nullptr || level < map->header().first_level || level >= map->header().level_count()) return view;
  const multum::PartShape shape = map->shape(part);
  if (shape.layers == 0) return view;
  return {nullptr, shape.layers, mip_level_size(map->header().height, level),
          mip_level_size(map->header().width, level), shape.channels};
}

namespace multum {
namespace {

// Returns the shape of a part that exists.
multum_view checked_shape(const multum_map& map, int level, multum_part part) {
  check_part(part);
  map.check_level(level);
  const multum_view view = multum_map_shape(&map, level, part);
  if (view.layers == 0)
    throw Error(ErrorCode::kUsage, fmt::format("part is {}, but the file {} has the representation {}, which does not "
                                               "contain this part; expected another part",
                                               kPartNames[part], map.path(), map.text("representation")));
  return view;
}

}  // namespace
}  // namespace multum

multum_status multum_map_level(multum_map* map, int level, multum_part part, multum_view* view, multum_error** error) {
  return guarded(error, [&] {
    multum::require(map, "multum_map_level", "map", "a map");
    multum::require(view, "multum_map_level", "view", "a place for the result");
    const multum::ApiCall call(nullptr);
    multum_view found = multum::checked_shape(*map, level, part);
    found.values = map->level(level)[static_cast<std::size_t>(part)].data();
    *view = found;
  });
}

void multum_map_forget(multum_map* map) {
  if (map != nullptr) map->forget();
}

multum_status multum_map_read(multum_map* map, int level, multum_part part, multum_region region, multum_type type,
                              void* values, multum_error** error) {
  return guarded(error, [&] {
    multum::require(map, "multum_map_read", "map", "a map");
    multum::require(values, "multum_map_read", "values", "room for the result");
    const multum::ApiCall call(nullptr);
    const multum_view shape = multum::checked_shape(*map, level, part);
    multum::check_type(type, map->header(), part);
    if (region.x < 0 || region.y < 0 || region.width < 1 || region.height < 1 ||
        region.width > shape.width - region.x || region.height > shape.height - region.y)
      throw Error(ErrorCode::kUsage,
                  fmt::format("region is {} x {} texels at ({}, {}), expected a part of level {} of {} x {}",
                              region.width, region.height, region.x, region.y, level, shape.width, shape.height));
    const PartValues rows = map->read(level, region.y, region.height);
    const std::vector<float>& from = rows[static_cast<std::size_t>(part)];
    const auto channels = static_cast<std::size_t>(shape.channels);
    const std::size_t count = static_cast<std::size_t>(region.width) * channels;
    auto* to = static_cast<unsigned char*>(values);
    for (int row = 0; row < shape.layers * region.height; ++row, to += count * multum::type_bytes(type))
      multum::store_row(from.data() + (static_cast<std::size_t>(row) * static_cast<std::size_t>(shape.width) +
                                       static_cast<std::size_t>(region.x)) *
                                          channels,
                        count, type, to);
  });
}
