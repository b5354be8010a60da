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

// The members of the report that the note of a share contains. This list is used for writing and for reading.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(NormalMapReport, format, encoding, encoding_reason, unused_texels,
                                   nonfinite_repaired, zero_length_repaired, below_horizon_repaired, wrap_s, wrap_t,
                                   tiles, warnings)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RoughnessReport, mean_cosine, least, mean, most, share_zero, share_one, share_mirror,
                                   warnings)

namespace {

using NoteJson = nlohmann::json;  // all members must have types that NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE supports

// Map rows use negative level numbers. Level -1 holds the planes of normals, one after another. Levels -2 and below
// hold features, in rows of three planes. Normals are split into blocks that fit into a record for any width of the
// map, and are read in place.
constexpr int kNormalsLevel = -1;
constexpr int level_of_feature(std::size_t store) { return kNormalsLevel - static_cast<int>(store); }
constexpr int kPlaneRows = 32, kFeatureRows = kPlaneRows / 3;
constexpr std::uint64_t kPlaneGap = sizeof(RowBlock) + RecordFile::kHeadBytes + RecordFile::kChecksumBytes;

// Lists the stores of normals, then the stores of features. Each store has three planes.
template <typename Source, typename Store>
std::vector<Store*> stores_of(Source& source) {
  std::vector<Store*> stores = {&source.map.normals};
  if (source.albedo) stores.push_back(&*source.albedo);
  if (source.weights)
    for (auto& planes : source.weights->rgb_planes) stores.push_back(&planes);
  return stores;
}

// Makes the source that a note describes. Normals are read in place. Other planes have no rows yet.
BakeSource source_of(const NoteJson& note, const std::string& share, std::uint64_t normals_begin,
                     const SpillPolicy& spill) {
  const int width = json_int(note, "width"), height = json_int(note, "height"),
            weight_count = json_int(note, "weights");
  if (width < 1 || height < 1 || width > 32768 || height > 32768 || weight_count < 0 || weight_count > 4)
    throw Error(ErrorCode::kEnvironment, share + ": does not contain a valid description of its map");
  const PlaneBlocks blocks{normals_begin, kPlaneGap, kPlaneRows};
  BakeSource source{
      {PlaneStore(width, height, ScratchFile::to_read(share), blocks), note.at("report").get<NormalMapReport>()},
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

// A merge needs all rows.
LevelRows wanted_rows(const BakeJob& job, const BakeSource& source) {
  if (!job.shard) return {0, source.map.normals.height()};
  const MovmfSettings settings = fitting_settings(job, source.map.report.wrap_s, source.map.report.wrap_t);
  const MipSchedule schedule = make_mip_schedule(source.map.normals, settings);
  return map_rows(plan_shard(schedule, settings, *job.shard), schedule, settings);
}

// Checks the rows of normals, which are read in place later, and copies the rows of features.
void read_map_rows(RowRecords& rows, const LevelRows& wanted, const std::string& path, BakeSource& source) {
  const std::vector<PlaneStore*> stores = stores_of<BakeSource, PlaneStore>(source);
  const auto width = static_cast<std::size_t>(source.map.normals.width());
  const int height = source.map.normals.height();
  const std::size_t row_bytes = width * sizeof(float);
  if (rows.row_count(kNormalsLevel, {row_bytes, 0, 0}) != 3 * height)
    throw Error(ErrorCode::kEnvironment, path + ": its number of rows does not match the size of its map");
  std::vector<float> row(3 * width);
  for (int plane = 0; plane < 3; ++plane)
    for (int y = wanted.begin; y < wanted.end; ++y)
      rows.read(kNormalsLevel, RowPart::kLobes, plane * height + y, 1, row.data());
  for (std::size_t s = 1; s < stores.size(); ++s) {
    if (rows.row_count(level_of_feature(s), {3 * row_bytes, 0, 0}) != height)
      throw Error(ErrorCode::kEnvironment, path + ": its number of rows does not match the size of its map");
    for (int y = wanted.begin; y < wanted.end; ++y) {
      rows.read(level_of_feature(s), RowPart::kLobes, y, 1, row.data());
      stores[s]->write_rows(y, 1, {row.data(), row.data() + width, row.data() + 2 * width});
    }
  }
}

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

void write_map_rows(const BakeSource& source, ShareWriter& writer) {
  const auto stores = stores_of<const BakeSource, const PlaneStore>(source);
  const int height = source.map.normals.height();
  const auto width = static_cast<std::size_t>(source.map.normals.width());
  const std::uint64_t row_bytes = width * sizeof(float);
  std::vector<float> rows(kPlaneRows * width);
  for (int plane = 0; plane < 3; ++plane)
    for (int first = 0; first < height; first += kPlaneRows) {
      const int count = std::min(kPlaneRows, height - first);
      source.map.normals.read_rows(plane, first, count, rows.data());
      writer.add_rows({kNormalsLevel, plane * height + first, count, 0, {row_bytes, 0, 0}}, {rows.data()});
    }
  for (std::size_t s = 1; s < stores.size(); ++s)
    for (int first = 0; first < height; first += kFeatureRows) {
      const int count = std::min(kFeatureRows, height - first);
      for (int i = 0; i < count; ++i) {
        float* const row = rows.data() + 3 * width * static_cast<std::size_t>(i);
        stores[s]->read_rows(first + i, 1, {row, row + width, row + 2 * width});
      }
      writer.add_rows({level_of_feature(s), first, count, 0, {3 * row_bytes, 0, 0}}, {rows.data()});
    }
}

void take_share_hashes(const BakeJob& job) {
  NoteJson note;
  try {
    RowRecords rows;
    note = NoteJson::parse(ShareFile(job.output, {0, job.shard->count}, nullptr, rows).note(), nullptr, false);
  } catch (const Error&) {
    return;  // the error is reported by the code that needs the share
  }
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
  RowRecords rows;
  const ShareFile share(job.output, {0, share_count(job)}, &key, rows);
  // A merge reads all rows of features, and a band reads only a few of them.
  const SpillPolicy spill = {scratch_folder(job),
                             job.memory_bytes > 0 || !job.shard ? std::int64_t{16} << 20 : std::int64_t{1} << 30};
  std::optional<BakeSource> source;
  try {
    source = source_of(NoteJson::parse(share.note()), share.path(), rows.begin_of(kNormalsLevel), spill);
  } catch (const NoteJson::exception&) {
    throw Error(ErrorCode::kEnvironment, share.path() + ": does not contain a valid description of its map");
  }
  // Writing the last row gives the scratch file its full length.
  const std::vector<float> row(static_cast<std::size_t>(source->map.normals.width()));
  for (PlaneStore* store : stores_of<BakeSource, PlaneStore>(*source))
    if (store != &source->map.normals) store->write_rows(store->height() - 1, 1, {row.data(), row.data(), row.data()});
  const LevelRows wanted = wanted_rows(job, *source);
  for_each_piece(wanted.begin, wanted.end - wanted.begin, source->map.normals.height(), [&](int begin, int count, int) {
    read_map_rows(rows, {begin, begin + count}, share.path(), *source);
  });
  return std::move(*source);
}

}  // namespace multum
