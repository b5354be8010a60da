// SPDX-License-Identifier: Apache-2.0
// Bakes lobes (von Mises-Fisher distributions or planar Gaussians) from file to file.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "host/bakes/accuracy/models/movmf_model.h"
#include "host/bakes/bake/bake_output.h"
#include "host/bakes/bake/file_bake_steps.h"
#include "host/bakes/bake/output_state.h"
#include "host/bakes/bake/shard_source.h"
#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_verify.h"
#include "host/formats/asset/lobes/movmf_writer.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/option_words.h"

namespace multum {
namespace {

// If a larger share of normals is in lobes that are too sharp, a warning is printed. Every map has some such lobes at
// level 1, where two or three normals of a lobe are nearly equal. With snorm16, the share is 2 to 28 % on ordinary maps
// and 36 to 57 % on surfaces with rms slopes of 0.01. Such slopes are visible only on glossy materials.
constexpr double kUnrepresentableNoted = 1.0 / 3.0;

void warn_of_sharp_lobes(const BakeJob& job, const MovmfMipmap& header, OutputReport& report) {
  double texels = 0.0;
  // Lobes of level 0 are single directions.
  for (std::size_t l = static_cast<std::size_t>(std::max(1, header.header.first_level)); l < header.levels.size(); ++l)
    texels += static_cast<double>(header.levels[l].width) * header.levels[l].height;
  if (texels > 0.0) report.unrepresentable_share = report.unrepresentable_amplitude / texels;
  if (report.unrepresentable_share <= kUnrepresentableNoted) return;
  const LobeFamily& family = lobe_family(header.header.representation);
  const auto kappa_max = static_cast<double>(family.kappa_max(header.header.encoding));
  log_warning(
      job.input,
      fmt::format(
          "{} lobes, which represent {:.0f} % of the normals, are sharper than kappa {:.0f} and lose their width in "
          "{}, so sharp highlights (Blinn-Phong with s = {:.0f} or more) become too sharp{}",
          report.unrepresentable, 100.0 * report.unrepresentable_share, kappa_max,
          storage_encoding_name(header.header.encoding), kappa_max,
          header.header.encoding == StorageEncoding::kHalf
              ? advice(fmt::format("; <data_format snorm16> stores kappa up to {:.0f}, and float stores larger values",
                                   family.kappa_max(StorageEncoding::kSnorm16)))
              : advice("; <data_format float> keeps them")));
}

// Bakes of maps up to this size do not keep the rows of the finest fitted level, unless the bake is resumed. Three
// quarters of all texels are on that level. The fit of such a map takes a few seconds, and writing the rows would add a
// fifth of that time.
constexpr std::int64_t kQuickTexels = std::int64_t{4096} * 4096;

// Returns the bytes of the tile rows that the writer holds. These rows belong to the fitted level and, if it is stored,
// to level 0.
std::uint64_t waiting_bytes(const BakeRun& run) {
  const BakedHeader& header = run.header;
  const std::uint64_t features = (header.has_colours ? 3u : 0u) + static_cast<std::uint64_t>(header.weight_count);
  const auto lobes = static_cast<std::uint64_t>(run.job.fitting.lobe_count);
  const int level = std::min(std::max(1, header.first_level), header.level_count() - 1),
            tile = run.job.writing.tile_size;
  return tile_row_bytes(header, level, tile, lobes * (4 + features)) +
         (header.first_level == 0 ? tile_row_bytes(header, 0, tile, 4 + features) : 0);
}

void bake_lobe_shard(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  const MapShard& shard = *job.shard;
  const std::string key = rows_key(run.header.provenance);
  ShareWriter writer(report.shard, key, shard.index > 0 ? "" : shard_note(job, run.source));
  if (shard.index == 0) write_map_rows(run.source, writer);
  ShareRows rows(run.spill, shard, plan_shard(make_mip_schedule(*run.normals, run.fitting), run.fitting, shard),
                 job.output, key, writer);
  const auto units = movmf_bake_units(run.header.width, run.header.height, job.fitting.first_level);
  progress_start(progress, shard.index == 0 ? units : units / static_cast<std::uint64_t>(shard.count));
  bake_movmf(run.device, run, run.fitting, rows, job.starts.get(), report.fit, progress);
  run.clock.finish("fit");
  progress_stage(progress, "write");
  writer.commit();
  run.clock.finish("write");
}

// Makes the rows of a bake that is not a share.
std::unique_ptr<RowOrigin> make_rows(const BakeRun& run, const MovmfMipmap& header, BakeOutput& output) {
  const BakeJob& job = run.job;
  const std::string key = rows_key(header.header.provenance);
  if (job.merged_shards > 0) return std::make_unique<GatheredRows>(&output, job.output, job.merged_shards, key);
  if (!job.onto.empty()) return std::make_unique<RegionBake>(job.onto, header, *job.region, run.spill, output);
  const bool has_finest = job.resume || std::int64_t{run.header.width} * run.header.height > kQuickTexels;
  if (auto rows = ResumedRows::open(&output, run.spill, job.output, key, job.resume, has_finest)) return rows;
  // Another process bakes the same output.
  return std::make_unique<RowOrigin>(&output, run.spill);
}

// Bakes a region, or the whole map.
void bake_lobe_file(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  if (job.shard) return bake_lobe_shard(run, report, progress);
  const int width = run.header.width, height = run.header.height;
  // Measuring counts as approximately the work of one level, and so does writing.
  const std::uint64_t level_units =
      movmf_bake_units(width, height) / static_cast<std::uint64_t>(mip_level_count(width, height));
  progress_start(progress, movmf_bake_units(width, height, job.fitting.first_level) + 2 * level_units);
  const MovmfMipmap header = empty_movmf_mipmap(run.header, job.fitting.lobe_count);
  MovmfWriter writer(job.output, header, job.writing);
  std::optional<MovmfMeter> meter;
  if (job.measure) {
    meter.emplace(header, run.header.has_colours, accuracy_settings(job));
    run.device.prepare(
        {MovmfModel::program(run.device, job.representation, job.fitting.lobe_count, job.fitting.first_level)});
  }
  BakeOutput output(writer, meter ? &*meter : nullptr, header, job.threads, report.output);
  MapInputs map = run;
  map.writer_bytes = run.memory_bytes - memory_beside_writer(run, waiting_bytes(run));
  const std::unique_ptr<RowOrigin> rows = make_rows(run, header, output);
  try {
    bake_movmf(run.device, map, run.fitting, *rows, job.starts.get(), report.fit, progress);
  } catch (const Cancelled&) {
    if (job.resume) rows->leave();
    throw;
  }
  report.rows_resumed = rows->rows_resumed();
  run.clock.finish("fit");
  warn_of_sharp_lobes(job, header, report.output);
  measure_and_commit(run, meter ? &*meter : nullptr, level_units, writer, report, progress);
  if (job.merged_shards > 0) remove_shards(job.output, job.merged_shards);
}

std::unique_ptr<AccuracyMeter> try_lobes(const BakeRun& run, const AccuracySettings& accuracy, BakeReport& report,
                                         Progress* progress) {
  MovmfMipmap mipmap = bake_movmf(run.device, run, run.fitting, report.fit, progress, run.job.starts.get());
  mipmap.header.encoding = run.header.encoding;
  mipmap.header.mean_cosine = run.header.mean_cosine;
  quantize_movmf(mipmap, run.job.threads);
  run.clock.finish("fit");
  auto meter = std::make_unique<MovmfMeter>(mipmap, run.header.has_colours, accuracy);
  for (int l = run.header.first_level; l < run.header.level_count(); ++l)
    meter->add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
  return meter;
}

void check_lobe_settings(const BakeJob& job) {
  validate(job.fitting);
  if (job.region && job.onto.empty())
    throw Error(ErrorCode::kUsage, "--region needs --onto, the file that was baked before this part was edited");
  const char* const option = job.shard ? "--shard" : job.merged_shards > 0 ? "--merge" : nullptr;
  if (option == nullptr) return;
  if (!job.onto.empty()) throw Error(ErrorCode::kUsage, std::string(option) + " and --onto are mutually exclusive");
  if (job.fitting.refine)
    throw Error(
        ErrorCode::kUsage,
        std::string(option) + " and --refine are mutually exclusive, because shares store only one set of lobes");
}

VerifiedFile verify_lobe_file(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress) {
  const MovmfMipmap header = read_movmf_header(job.output);
  return verify_by_rows<MovmfLevel>(verify_movmf, job,
                                    std::make_unique<MovmfMeter>(header, header.has_colours(), accuracy), progress);
}

constexpr NdfBake lobe_bake(Representation representation) {
  return {
      representation,
      check_lobe_settings,
      [](const BakeJob& job) { return settings_json(fitting_settings(job, job.reading.wrap_s, job.reading.wrap_t)); },
      [](const BakeJob& job, int width, int height) { validate(job.fitting, width, height); },
      bake_lobe_file,
      try_lobes,
      verify_lobe_file};
}

}  // namespace

const NdfBake kMovmfBake = lobe_bake(Representation::kMovmf);
const NdfBake kGmmBake = lobe_bake(Representation::kGmm);

}  // namespace multum
