// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/bake/output_state.h"
#include "host/bakes/bake/shard_source.h"
#include "host/formats/image/normals/tile_set.h"
#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/memory_gate.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

// Programs choose a reader by the extension, so they would treat a baked file named .png as a broken picture.
void check_output_name(const std::string& path) {
  if (!path.ends_with(".exr"))
    throw Error(ErrorCode::kUsage,
                path + ": is not a valid name for a baked file, expected a name that ends in .ndf.exr or .exr");
}

// Reports the device's work for a bake.
void report_counts(const DeviceCounts& counts, Device& device, BakeReport& report) {
  report.launches = counts.launches();
  report.builds = counts.builds();
  report.launch_seconds = counts.launch_seconds();
  report.transfers = counts.transfers();
  report.device_bytes_peak = device.buffer_bytes_peak();
}

// The memory that the process needs for a map of any size. It holds the program, the OpenCL driver with its compiler,
// and rows that wait to be rounded and compressed. With PoCL 3.1, the process used 215 MiB before the first texel was
// fitted.
constexpr std::uint64_t kProcessBytes = std::uint64_t{224} << 20;
constexpr std::uint64_t kQueueBytes = std::uint64_t{56} << 20;
constexpr std::uint64_t kRoomy = std::uint64_t{128} << 20;  // memory above the minimum on small machines

// The default is 5/32 of the machine's memory: a quarter, minus 3/32 for up to three maps
// (host/bakes/bake/bake_source.cpp). In a small container, this share is too small. The default is then the bake's
// minimum plus kRoomy, up to seven eighths of the memory. The process can run with less memory than it asks for,
// because the system can drop pages of libraries. For example, maps of 4096 x 4096 texels were baked with 400 MB.
std::uint64_t machine_share() { return machine_memory_bytes() / 32 * 5; }

std::uint64_t usual_memory(std::uint64_t least) {
  const std::uint64_t all = machine_memory_bytes(), most = all / 8 * 7;
  if (most < least)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("not enough memory to bake: this process can use {} MiB (the machine's memory, or the "
                            "limit of its container or shell), expected at least {} MiB",
                            all >> 20, (least / 7 * 8 >> 20) + 1));
  return std::max(machine_share(), std::min(least + kRoomy, most));
}

constexpr std::uint64_t kTaken = kProcessBytes + kQueueBytes, kLeast = std::uint64_t{8} << 20;

std::uint64_t window_bytes(const BakeJob& job) {
  const std::uint64_t memory = job.memory_bytes > 0 ? job.memory_bytes : usual_memory(kTaken + kLeast);
  if (memory < kTaken + kLeast)
    throw Error(ErrorCode::kUsage, fmt::format("--memory is {} MiB, expected at least {} MiB, because the program, its "
                                               "OpenCL driver and the rows that wait to be written need {} MiB",
                                               memory >> 20, (kTaken + kLeast) >> 20, kTaken >> 20));
  return memory - kTaken;
}

// The memory that one more bake needs in a process that already bakes. A process that baked one map with 4 lobes and
// measured it used 131 MB for 64 x 64 texels, 200 MB for 512 x 512, 260 MB for 1024 x 1024, and 383 MB for 2048 x 2048.
// Larger maps need less per texel, because they are baked in bands of rows.
std::uint64_t bytes_beside_others(const PlaneStore& map) {
  constexpr std::uint64_t kLeastBake = std::uint64_t{32} << 20, kBytesPerTexel = 200;
  const auto texels = static_cast<std::uint64_t>(map.width()) * static_cast<std::uint64_t>(map.height());
  return kLeastBake + texels * kBytesPerTexel;
}

// `tiles` lists the other tiles of the set that were used to make the result of this map.
BakedProvenance make_provenance(const BakeJob& job, const std::string& source, const std::string& settings,
                                const std::string& tiles = "") {
  BakedProvenance from;
  from.software = software_version();
  from.source_name = source;
  from.source_hash = job.hashes->hash(job.input);
  if (!tiles.empty()) {
    from.source_file_hash = from.source_hash;
    from.source_tiles = tiles;
    from.source_hash = tile_source_hash(from.source_file_hash, tiles);
  }
  from.settings = settings;
  from.settings_hash = hash_text(settings);
  return from;
}

// Returns the map that share 0 has decoded. Returns nullopt if share 0 is missing or damaged. GatheredRows then lists
// the missing shares. If no share is missing, the caller reads the map itself.
std::optional<BakeSource> source_of_shares(const BakeJob& job, const std::string& key) {
  try {
    return read_shard_source(job, key);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEnvironment) throw;
    return std::nullopt;
  }
}

// Sets the job's region if the job bakes a region again.
BakeJob with_region(BakeJob job, const BakeSource& source) {
  if (job.onto.empty()) return job;
  const MovmfMipmap header = empty_movmf_mipmap(baked_header_of(job, source), job.fitting.lobe_count);
  job.region =
      resolve_region(job.region, job.input, job.onto, header, source.map.normals, source.features(), job.threads);
  return job;
}

// Roughness shortens a lobe by a factor c, which also widens the lobe for diffuse light. The shader divides by the mean
// of c over the map (without_roughness in kernels/device/vmf_shading.clh), so an error remains at texels whose c
// differs from the mean. If roughness is nearly constant, this error is almost 0. On a map with polished and dull
// parts, the error exceeds the error of averaged normals at fine levels (docs/evidence/INPUT_MAPS.md has the
// measurements).
constexpr double kDiffuseErrorNoted = 0.02;
constexpr int kFineLevels = 2;

void warn_of_diffuse_error(const BakeJob& job, BakeReport& report) {
  if (!report.roughness) return;
  double error = 0.0;
  for (const AccuracyRow& row : report.accuracy)
    if (row.level < kFineLevels && row.point == AccuracyPoint::kCentre && row.brdf.kind == AccuracyBrdfKind::kLambert &&
        !row.brdf.has_colours)
      error = std::max(error, row.error);
  if (error <= kDiffuseErrorNoted) return;
  report.roughness->warnings.push_back(fmt::format(
      "{}: with roughness baked in, diffuse light has an error of up to {:.3g} % at levels 0 and 1, because roughness "
      "varies strongly over the map. Averaged normals are nearly exact at these levels. If diffuse light matters, "
      "compute it from the normal map, or bake without --{} (docs/reference/input_maps.md)",
      job.input, 100.0 * error, job.roughness_is_gloss ? "gloss" : "roughness"));
  log_named_warning(report.roughness->warnings.back());
}

}  // namespace

void check_job(const BakeJob& job) {
  std::error_code error;
  if (!job.scratch_folder.empty() && !std::filesystem::is_directory(job.scratch_folder, error))
    throw Error(ErrorCode::kEnvironment, job.scratch_folder + ": is not a folder, expected a folder for scratch files");
  check_encoding(job.representation, job.encoding);
  ndf_bake(job.representation).check_settings(job);
  if ((job.shard || job.merged_shards > 0) && !holds_lobes(job.representation))
    throw Error(ErrorCode::kUsage,
                fmt::format("{} is given, expected vMF lobes or planar Gaussians, because the bake of {} is a single "
                            "averaging pass that cannot be divided",
                            job.shard ? "--shard" : "--merge", representation_info(job.representation).name));
  validate(job.writing);
  check_paths_differ(input_files(job), {job.output, job.report});
  check_output_name(job.output);
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
}

int share_memory(const std::vector<BakeJob*>& jobs) {
  constexpr std::uint64_t kSmallBake = std::uint64_t{96} << 20;  // of a map of 512 x 512
  const BakeJob& first = *jobs.front();
  const std::uint64_t memory = first.memory_bytes > 0 ? first.memory_bytes : machine_share();
  if (memory < kTaken + 2 * kSmallBake) return 1;
  const auto gate = std::make_shared<MemoryGate>(memory - kTaken);
  for (BakeJob* job : jobs) job->memory_gate = gate;
  const auto most = std::min(jobs.size(), static_cast<std::size_t>(std::max(1, first.threads)));
  return static_cast<int>(std::min<std::uint64_t>(most, (memory - kTaken) / kSmallBake));
}

BakeReport unchanged_report(const BakeJob& job) {
  BakeReport report;
  report.source = std::filesystem::path(job.input).filename().string();
  report.unchanged = true;
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  return report;
}

BakeReport bake_file(const BakeJob& asked, const BakeSource* given, Device& device, Progress* progress) {
  const std::uint64_t memory_bytes = window_bytes(asked);  // first, because it reports a lack of memory
  check_job(asked);
  if (asked.shard && asked.shard->index > 0) take_share_hashes(asked);
  const std::string asked_settings = all_settings_json(asked);
  if (!asked.force && !asked.shard && find_output_state(asked, asked_settings).finding == OutputFinding::kInPlace)
    return unchanged_report(asked);
  BakeReport report;
  report.source = std::filesystem::path(asked.input).filename().string();
  StageClock clock(report);
  std::optional<BakeSource> read;
  if (asked.shard) {
    const std::string key = rows_key(make_provenance(asked, report.source, asked_settings));
    report.shard = shard_path(asked.output, *asked.shard);
    report.unchanged = !asked.force && has_shard(asked.output, *asked.shard, key);
    if (report.unchanged) return report;
    if (asked.shard->index > 0) read = read_shard_source(asked, key);
  } else if (asked.merged_shards > 0) {
    read = source_of_shares(asked, rows_key(make_provenance(asked, report.source, asked_settings)));
  }
  if (read) {
    note_source(*read, report);
    if (!asked.shard) log_source(asked, *read);
    clock.finish("read");
  } else if (given == nullptr) {
    read = read_source(asked, MapReadings::kFew, report, progress);
    clock.finish("read");
  } else {
    note_source(*given, report);
  }
  const BakeSource& source = read ? *read : *given;
  std::optional<MemoryGate::Pass> pass;
  if (asked.memory_gate) pass.emplace(*asked.memory_gate, bytes_beside_others(source.map.normals));
  BakeJob job = with_region(asked, source);
  if (asked.keeps_mosaic && !asked.shard) {
    report.mosaic = std::make_shared<const MapMosaic>(mosaic_of(source.map.normals, nullptr, kSmallMosaic));
    if (!job.starts) job.starts = std::make_shared<StartMemory>(false);
    report.starts = job.starts;
  }
  ndf_bake(job.representation).check_map(job, source.map.normals.width(), source.map.normals.height());
  const DeviceCounts counts(device);
  device.restart_buffer_peak();
  BakedHeader header = baked_header_of(job, source);
  header.provenance =
      make_provenance(job, report.source, job.region == asked.region ? asked_settings : all_settings_json(job),
                      source.map.report.tiles);
  header.provenance.reading = reading_json(job, source);
  report.first_level = header.first_level;
  report.stored_only = job.stored_only;
  report.device = device.info().name;
  const MovmfSettings fitting = fitting_settings(job, header.wrap_s, header.wrap_t);
  ndf_bake(job.representation)
      .bake({map_inputs(job, source, memory_bytes), job, device, source, header, fitting, clock}, report, progress);
  report_counts(counts, device, report);
  warn_of_diffuse_error(job, report);
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
