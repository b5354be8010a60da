// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/shard_source.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/bakes/bake/output_state.h"
#include "host/bakes/pyramid/row_window.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {

// As notes have them, written and read by one list.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(NormalMapReport, format, encoding, encoding_reason, unused_texels,
                                   nonfinite_repaired, zero_length_repaired, below_horizon_repaired, wrap_s, wrap_t,
                                   tiles, warnings)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RoughnessReport, mean_cosine, least, mean, most, share_zero, share_one, share_mirror,
                                   warnings)

namespace {

using NoteJson = nlohmann::json;  // whose types of members NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE knows

// In the place of levels: -1, -2 and -3 are planes of normals, -4 and so on features, of which a block has rows of
// three planes, one plane behind the other.
constexpr int level_of_plane(int plane) { return -1 - plane; }
constexpr int level_of_feature(std::size_t store) { return -3 - static_cast<int>(store); }
// Blocks are written whole (ShardWriter): so many rows of features are less than 4 MB, however wide a map may be.
constexpr int kFeatureRows = 8;
constexpr int kPlaneRows = 32;

// Normals, then features, three planes each.
template <typename Source, typename Store>
std::vector<Store*> stores_of(Source& source) {
  std::vector<Store*> stores = {&source.map.normals};
  if (source.albedo) stores.push_back(&*source.albedo);
  if (source.weights)
    for (auto& planes : source.weights->rgb_planes) stores.push_back(&planes);
  return stores;
}

// The source of a note, whose planes have no rows yet: normals are read where they are.
BakeSource source_of(const NoteJson& note, const std::string& share, const SpillPolicy& spill) {
  const int width = json_int(note, "width"), height = json_int(note, "height"),
            weight_count = json_int(note, "weights");
  if (width < 1 || height < 1 || width > 32768 || height > 32768 || weight_count < 0 || weight_count > 4)
    throw Error(ErrorCode::kEnvironment, share + ": says nothing of its map");
  BakeSource source{{PlaneStore(width, height, ScratchFile::to_read(share)), note.at("report").get<NormalMapReport>()},
                    std::nullopt,
                    std::nullopt};
  source.map.normals.set_shortened(note.at("shortened").get<bool>());
  note.at("mean_cosine").get_to(source.mean_cosine);
  if (note.contains("roughness")) source.roughness = note.at("roughness").get<RoughnessReport>();
  note.at("albedo_clamped").get_to(source.albedo_clamped);
  note.at("map_warnings").get_to(source.map_warnings);
  note.at("albedo_format").get_to(source.albedo_format);
  if (note.at("albedo").get<bool>()) source.albedo.emplace(make_plane_store(width, height, spill));
  if (weight_count > 0) {
    source.weights.emplace();
    source.weights->count = weight_count;
    for (int i = 0; i < weight_count; i += 3)
      source.weights->rgb_planes.push_back(make_plane_store(width, height, spill));
  }
  return source;
}

// All of them for a merge.
LevelRows wanted_rows(const BakeJob& job, const BakeSource& source) {
  if (!job.shard) return {0, source.map.normals.height()};
  const MovmfSettings settings = fitting_settings(job, source.map.report.wrap_s, source.map.report.wrap_t);
  const MipSchedule schedule = make_mip_schedule(source.map.normals, settings);
  return map_rows(plan_shard(schedule, settings, *job.shard), schedule, settings);
}

// Looks at rows of normals, which are read again where they are, and copies those of features.
class RowReading {
 public:
  RowReading(ShardReader& share, std::string path, BakeSource& source)
      : share_(share),
        path_(std::move(path)),
        stores_(stores_of<BakeSource, PlaneStore>(source)),
        width_(static_cast<std::size_t>(source.map.normals.width())),
        height_(source.map.normals.height()) {}

  void read(const LevelRows& rows) {
    for (int plane = 0; plane < 3; ++plane)
      read_level(level_of_plane(plane), rows, width_ * sizeof(float), [&](const ShardReader::Rows& found) {
        const std::int64_t row = std::int64_t{plane} * height_ + found.first_row;
        if (found.begin != row * static_cast<std::int64_t>(width_ * sizeof(float))) refuse();
      });
    for (std::size_t s = 1; s < stores_.size(); ++s)
      read_level(level_of_feature(s), rows, 3 * width_ * sizeof(float), [&](const ShardReader::Rows& found) {
        const auto* values = static_cast<const float*>(found.lobes);
        const std::size_t plane = width_ * static_cast<std::size_t>(found.row_count);
        stores_[s]->write_rows(found.first_row, found.row_count, {values, values + plane, values + 2 * plane});
      });
  }

 private:
  [[noreturn]] void refuse() const {
    throw Error(ErrorCode::kEnvironment, path_ + ": has other rows than its map should");
  }

  template <typename Take>
  void read_level(int level, const LevelRows& rows, std::size_t row_bytes, const Take& take) {
    int next = rows.begin;
    share_.read(level, rows, [&](const ShardReader::Rows& found) {
      if (found.lobe_row_bytes != row_bytes || found.feature_row_bytes != 0 || found.first_row > next ||
          found.row_count > height_ - found.first_row)
        refuse();
      next = found.first_row + found.row_count;
      take(found);
    });
    if (next < rows.end) refuse();
  }

  ShardReader& share_;
  const std::string path_;
  const std::vector<PlaneStore*> stores_;
  const std::size_t width_;
  const int height_;
};

int share_count(const BakeJob& job) { return job.shard ? job.shard->count : job.merged_shards; }

}  // namespace

std::string shard_note(const BakeJob& job, const BakeSource& source) {
  NoteJson note = {{"width", source.map.normals.width()},
                   {"height", source.map.normals.height()},
                   {"shortened", source.has_roughness()},
                   {"albedo", source.albedo.has_value()},
                   {"weights", source.weights ? source.weights->count : 0},
                   {"mean_cosine", source.mean_cosine},
                   {"albedo_clamped", source.albedo_clamped},
                   {"map_warnings", source.map_warnings},
                   {"albedo_format", source.albedo_format},
                   {"report", source.map.report},
                   {"files", NoteJson::array()}};
  if (source.roughness) note["roughness"] = *source.roughness;
  for (const std::string& file : input_files(job)) {
    const InputHashes::FileState state = job.hashes->state(file);
    note["files"].push_back({state.size, state.modified_ns, job.hashes->hash(file)});
  }
  return json_text(note);
}

void write_map_rows(const BakeSource& source, ShardWriter& writer) {
  const auto stores = stores_of<const BakeSource, const PlaneStore>(source);
  const int height = source.map.normals.height();
  const auto width = static_cast<std::size_t>(source.map.normals.width());
  std::vector<float> rows(width * std::max(kPlaneRows, 3 * kFeatureRows));
  for (int plane = 0; plane < 3; ++plane)
    for (int first = 0; first < height; first += kPlaneRows) {
      const int count = std::min(kPlaneRows, height - first);
      source.map.normals.read_rows(plane, first, count, rows.data());
      writer.add_rows(level_of_plane(plane), first, count, width * sizeof(float), rows.data(), 0, nullptr);
    }
  for (std::size_t s = 1; s < stores.size(); ++s)
    for (int first = 0; first < height; first += kFeatureRows) {
      const int count = std::min(kFeatureRows, height - first);
      const std::size_t plane = width * static_cast<std::size_t>(count);
      stores[s]->read_rows(first, count, {rows.data(), rows.data() + plane, rows.data() + 2 * plane});
      writer.add_rows(level_of_feature(s), first, count, 3 * width * sizeof(float), rows.data(), 0, nullptr);
    }
}

void take_share_hashes(const BakeJob& job) {
  const NoteJson note = NoteJson::parse(ShardReader::note_of(job.output, {0, job.shard->count}), nullptr, false);
  if (!note.is_object() || !note.contains("files")) return;
  const std::vector<std::string> files = input_files(job);
  const NoteJson& there = note["files"];
  if (!there.is_array() || there.size() != files.size()) return;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const NoteJson& file = there[i];
    if (!file.is_array() || file.size() != 3 || !file[0].is_number_integer() || !file[1].is_number_integer() ||
        !file[2].is_string())
      return;
    job.hashes->take(files[i], {file[0].get<std::int64_t>(), file[1].get<std::int64_t>()}, file[2].get<std::string>());
  }
}

BakeSource read_shard_source(const BakeJob& job, const std::string& key) {
  const MapShard first{0, share_count(job)};
  const std::string path = shard_path(job.output, first);
  ShardReader share(job.output, first, key);
  // A merge reads all rows of features, a band few.
  const SpillPolicy spill = {scratch_folder(job),
                             job.memory_bytes > 0 || !job.shard ? std::int64_t{16} << 20 : std::int64_t{1} << 30};
  std::optional<BakeSource> source;
  try {
    source = source_of(NoteJson::parse(share.note()), path, spill);
  } catch (const NoteJson::exception&) {
    throw Error(ErrorCode::kEnvironment, path + ": says nothing of its map");
  }
  // A scratch file is as long as what was written to it.
  const std::vector<float> row(static_cast<std::size_t>(source->map.normals.width()));
  for (PlaneStore* store : stores_of<BakeSource, PlaneStore>(*source))
    if (store != &source->map.normals) store->write_rows(store->height() - 1, 1, {row.data(), row.data(), row.data()});
  const LevelRows wanted = wanted_rows(job, *source);
  RowReading reading(share, path, *source);
  for_each_piece(wanted.begin, wanted.end - wanted.begin, source->map.normals.height(), [&](int begin, int count, int) {
    reading.read({begin, begin + count});
  });
  return std::move(*source);
}

}  // namespace multum
