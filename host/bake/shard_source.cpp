// SPDX-License-Identifier: Apache-2.0
#include "host/bake/shard_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <sstream>
#include <vector>

#include "host/bake/output_state.h"
#include "host/base/error.h"
#include "host/pyramid/row_window.h"

namespace multum {
namespace {

constexpr int kMapRows = -1;  // in the place of a level
constexpr int kRowsABlock = 32;

// Normals, then features, three planes each.
template <typename Source, typename Store>
std::vector<Store*> stores_of(Source& source) {
  std::vector<Store*> stores = {&source.map.normals};
  if (source.albedo) stores.push_back(&*source.albedo);
  if (source.weights)
    for (auto& planes : source.weights->rgb_planes) stores.push_back(&planes);
  return stores;
}

// Rows of three planes, one plane behind the other.
std::array<float*, 3> planes_in(float* begin, std::size_t plane_values) {
  return {begin, begin + plane_values, begin + 2 * plane_values};
}

}  // namespace

std::string shard_note(const BakeSource& source) {
  return fmt::format("map {} {} {} {} {:x} {} {} {}", source.map.normals.width(), source.map.normals.height(),
                     static_cast<int>(source.map.report.wrap_s), static_cast<int>(source.map.report.wrap_t),
                     std::bit_cast<std::uint64_t>(source.mean_cosine), source.has_roughness() ? 1 : 0,
                     source.albedo ? 1 : 0, source.weights ? source.weights->count : 0);
}

void write_map_rows(const BakeSource& source, ShardWriter& writer) {
  const auto stores = stores_of<const BakeSource, const PlaneStore>(source);
  const int height = source.map.normals.height();
  const auto width = static_cast<std::size_t>(source.map.normals.width());
  std::vector<float> rows(3 * stores.size() * width * kRowsABlock);
  for (int first = 0; first < height; first += kRowsABlock) {
    const int count = std::min(kRowsABlock, height - first);
    const std::size_t plane = width * static_cast<std::size_t>(count);
    for (std::size_t s = 0; s < stores.size(); ++s)
      stores[s]->read_rows(first, count, planes_in(rows.data() + 3 * s * plane, plane));
    writer.add_rows(kMapRows, first, count, 3 * stores.size() * width * sizeof(float), rows.data(), 0, nullptr);
  }
}

BakeSource read_shard_source(const BakeJob& job, const std::string& key) {
  ShardReader coarse(job.output, {0, job.shard->count}, key);
  std::istringstream words(coarse.note());
  std::string kind;
  int width = 0, height = 0, wrap_s = 0, wrap_t = 0, shortened = 0, has_albedo = 0, weight_count = 0;
  std::uint64_t mean_cosine = 0;
  if (!(words >> kind >> width >> height >> wrap_s >> wrap_t >> std::hex >> mean_cosine >> std::dec >> shortened >>
        has_albedo >> weight_count) ||
      kind != "map" || width < 1 || height < 1 || width > 32768 || height > 32768 || weight_count < 0 ||
      weight_count > 4)
    throw Error(ErrorCode::kEnvironment, shard_path(job.output, {0, job.shard->count}) + ": says nothing of its map");
  const SpillPolicy spill = {scratch_folder(job),
                             job.memory_bytes > 0 ? std::int64_t{16} << 20 : std::int64_t{1} << 30};
  NormalMapRows map{make_plane_store(width, height, spill), {}};
  BakeSource source{std::move(map), std::nullopt, std::nullopt};
  source.map.normals.set_shortened(shortened != 0);
  source.map.report.wrap_s = static_cast<WrapMode>(wrap_s);
  source.map.report.wrap_t = static_cast<WrapMode>(wrap_t);
  source.mean_cosine = std::bit_cast<double>(mean_cosine);
  if (has_albedo != 0) source.albedo.emplace(make_plane_store(width, height, spill));
  if (weight_count > 0) {
    source.weights.emplace();
    source.weights->count = weight_count;
    for (int i = 0; i < weight_count; i += 3)
      source.weights->rgb_planes.push_back(make_plane_store(width, height, spill));
  }
  const auto stores = stores_of<BakeSource, PlaneStore>(source);
  // A scratch file is as long as what was written to it.
  const std::vector<float> row(static_cast<std::size_t>(width));
  for (PlaneStore* store : stores) store->write_rows(height - 1, 1, {row.data(), row.data(), row.data()});
  const MovmfSettings settings = fitting_settings(job, source.map.report.wrap_s, source.map.report.wrap_t);
  const MipSchedule schedule = make_mip_schedule(source.map.normals, settings);
  const LevelRows wanted = map_rows(plan_shard(schedule, settings, *job.shard), schedule, settings);
  for_each_piece(wanted.begin, wanted.end - wanted.begin, height, [&](int first, int count, int) {
    coarse.read(kMapRows, {first, first + count}, [&](const ShardReader::Rows& rows) {
      const std::size_t plane = static_cast<std::size_t>(width) * static_cast<std::size_t>(rows.row_count);
      if (rows.lobe_row_bytes != 3 * stores.size() * static_cast<std::size_t>(width) * sizeof(float) ||
          rows.first_row + rows.row_count > height)
        throw Error(ErrorCode::kEnvironment,
                    shard_path(job.output, {0, job.shard->count}) + ": has other rows than its map should");
      const auto* values = static_cast<const float*>(rows.lobes);
      for (std::size_t s = 0; s < stores.size(); ++s, values += 3 * plane)
        stores[s]->write_rows(rows.first_row, rows.row_count, {values, values + plane, values + 2 * plane});
    });
  });
  return source;
}

}  // namespace multum
