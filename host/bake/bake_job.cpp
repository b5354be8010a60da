// SPDX-License-Identifier: Apache-2.0
#include "host/bake/bake_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "host/bake/accuracy_table.h"
#include "host/bake/bake_sink.h"
#include "host/bake/bake_source.h"
#include "host/bake/movmf_bake.h"
#include "host/bake/output_state.h"
#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/machine.h"
#include "host/base/output_paths.h"

namespace multum {
namespace {

class StageClock {
 public:
  explicit StageClock(BakeReport& report) : report_(report) {}
  void finish(const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    report_.stages.push_back({name, std::chrono::duration<double>(now - last_).count()});
    last_ = now;
  }

 private:
  BakeReport& report_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// Lobes sharper than the storage keeps: counted, and warned of where they stand for more of the map than this. Every
// map has some at level 1, around two or three normals that are nearly alike. Measured on the test folder, snorm16: 2
// to 28 % of ordinary maps, 36 to 57 % of surfaces with slopes of 0.01 rms, which only a glossy material shows.
constexpr double kBeyondStorageNoted = 1.0 / 3.0;

void warn_of_sharp_lobes(const BakeJob& job, const MovmfMipmap& header, BakeReport& report) {
  double texels = 0.0;
  // Level 0 has single directions alone.
  for (std::size_t l = static_cast<std::size_t>(std::max(1, header.first_level)); l < header.levels.size(); ++l)
    texels += static_cast<double>(header.levels[l].width) * header.levels[l].height;
  if (texels > 0.0) report.beyond_storage_share = report.beyond_storage_amplitude / texels;
  if (report.beyond_storage_share <= kBeyondStorageNoted) return;
  const auto kappa_max = static_cast<double>(storage_kappa_max(header.encoding));
  log_warning(fmt::format(
      "{}: {} lobes, which stand for {:.0f} % of the normals, are sharper than kappa {:.0f} and lose their spread in "
      "{}: highlights about as sharp (Blinn-Phong of s = {:.0f} and more) come out too sharp; {}",
      job.input, report.beyond_storage, 100.0 * report.beyond_storage_share, kappa_max,
      storage_encoding_name(header.encoding), kappa_max,
      header.encoding == StorageEncoding::kHalf ? "--data-format snorm16 keeps kappa up to 20000, float more"
                                                : "--data-format float keeps them"));
}

// Programs choose a reader by the extension: a baked file named .png would be taken for a broken picture.
void check_output_name(const std::string& path) {
  if (!path.ends_with(".exr"))
    throw Error(ErrorCode::kUsage,
                path + ": is not a name for a baked file, expected one that ends in .ndf.exr or .exr");
}

// What has been launched since `before`, by kernel.
std::map<std::string, std::uint64_t> launches_since(const std::map<std::string, std::uint64_t>& before,
                                                    const Device& device) {
  std::map<std::string, std::uint64_t> launches;
  for (const auto& [kernel, count] : device.launch_counts()) {
    const auto earlier = before.find(kernel);
    const std::uint64_t more = count - (earlier == before.end() ? 0 : earlier->second);
    if (more > 0) launches[kernel] = more;
  }
  return launches;
}

// What the process takes whatever the map: the program, the OpenCL driver with its compiler, and the rows that wait to
// be rounded and compressed. Measured with PoCL 3.1: 215 MiB before the first texel.
constexpr std::uint64_t kProcessBytes = std::uint64_t{224} << 20;
constexpr std::uint64_t kQueueBytes = std::uint64_t{56} << 20;

std::uint64_t window_bytes(const BakeJob& job) {
  const std::uint64_t memory = job.memory_bytes > 0 ? job.memory_bytes : machine_memory_bytes() / 4;
  constexpr std::uint64_t kTaken = kProcessBytes + kQueueBytes, kLeast = std::uint64_t{8} << 20;
  if (memory < kTaken + kLeast)
    throw Error(ErrorCode::kUsage,
                fmt::format("--memory is {} MiB, expected at least {} MiB: {} of them are the program's own, with its "
                            "OpenCL driver and what waits to be written",
                            memory >> 20, (kTaken + kLeast) >> 20, kTaken >> 20));
  return memory - kTaken;
}

MovmfMipmap make_header(const BakeJob& job, int width, int height) {
  MovmfMipmap header;
  header.encoding = job.encoding;
  header.wrap_s = job.reading.wrap_s;
  header.wrap_t = job.reading.wrap_t;
  header.first_level = job.fitting.first_level;
  for (int l = 0; l < mip_level_count(width, height); ++l) {
    MovmfLevel& level = header.levels.emplace_back();
    level.width = mip_level_size(width, l);
    level.height = mip_level_size(height, l);
    level.lobes.resize(static_cast<std::size_t>(job.fitting.lobe_count));
    if (!job.albedo.empty()) level.colours.resize(level.lobes.size());
  }
  return header;
}

BakedProvenance make_provenance(const BakeJob& job, const std::string& source, const std::string& settings) {
  BakedProvenance from;
  from.software = bake_software();
  from.source_name = source;
  from.source_hash = hash_file(job.input);
  from.settings = settings;
  from.settings_hash = hash_text(settings);
  return from;
}

// What the rows of a bake depend on: what a killed bake left is of use to no other.
std::string checkpoint_key(const MovmfMipmap& header) {
  const BakedProvenance& from = header.provenance;  // the settings name the albedo's hash
  return hash_text(fmt::format("{}\n{}\n{}", from.software, from.settings, from.source_hash));
}

BakeSource read_source(const BakeJob& job, BakeReport& report, Progress* progress) {
  BakeSource source = read_bake_source(job, progress);
  const NormalMapReport& found = report.input = source.map.report;
  log_info(fmt::format("{}: {} x {}, {}; {}", job.input, source.map.normals.width(), source.map.normals.height(),
                       found.encoding, found.encoding_reason));
  for (const std::string& warning : found.warnings) log_warning(job.input + ": " + warning);
  validate(job.fitting, source.map.normals.width(), source.map.normals.height());
  return source;
}

// What can be told before anything is read.
void check_job(const BakeJob& job) {
  if (!job.scratch_folder.empty() && !std::filesystem::is_directory(job.scratch_folder))
    throw Error(ErrorCode::kEnvironment, job.scratch_folder + ": is not a folder, expected one for scratch files");
  validate(job.fitting);
  validate(job.writing);
  if (job.region.has_value() == job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto go together: the part that was edited, and the file that was "
                "baked before");
  check_paths_differ({job.input, job.albedo}, {job.output, job.report});
  check_output_name(job.output);
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
}

}  // namespace

BakeReport bake_file(const BakeJob& job, Device& device, Progress* progress) {
  const std::uint64_t memory_bytes = window_bytes(job);
  check_job(job);
  BakeReport report;
  report.source = std::filesystem::path(job.input).filename().string();
  const std::string settings = all_settings_json(job);
  if (!job.force && find_output_state(job, settings).finding == OutputFinding::kInPlace) {
    report.unchanged = true;
    if (!job.report.empty()) write_text_file(job.report, report.to_json());
    return report;
  }
  StageClock clock(report);
  const std::map<std::string, std::uint64_t> launches_before = device.launch_counts();
  const int programs_before = device.program_count();
  const BakeSource source = read_source(job, report, progress);
  const PlaneStore& normals = source.map.normals;
  const PlaneStore* const albedo = source.albedo ? &*source.albedo : nullptr;
  const int width = normals.width(), height = normals.height();
  clock.finish("read");

  // Measuring and writing count as about a level's work each.
  const std::uint64_t level_units =
      movmf_bake_units(width, height) / static_cast<std::uint64_t>(mip_level_count(width, height));
  progress_start(progress, movmf_bake_units(width, height, job.fitting.first_level) + 2 * level_units);
  MovmfMipmap header = make_header(job, width, height);
  header.provenance = make_provenance(job, report.source, settings);
  MovmfWriter writer(job.output, header, job.writing);
  AccuracySettings accuracy;
  accuracy.threads = job.threads;
  std::optional<AccuracyMeter> meter;
  if (job.measure) meter.emplace(header, albedo != nullptr, accuracy);
  BakeOutput output(writer, meter ? &*meter : nullptr, header, job.threads, report);
  MovmfBakeInputs inputs;
  inputs.normals = &normals;
  inputs.albedo = albedo;
  inputs.memory_bytes = memory_bytes;
  inputs.place.folder = scratch_folder(job);
  inputs.threads = job.threads;
  if (job.region) {
    RegionBake region(job.onto, header, *job.region, inputs.place, output);
    inputs.region = &region;
    bake_movmf(device, inputs, fitting_settings(job), region, report, progress);
    region.finish();
  } else {
    const std::unique_ptr<BakeCheckpoint> checkpoint =
        BakeCheckpoint::open(job.output, checkpoint_key(header), job.resume);
    inputs.checkpoint = checkpoint.get();
    BakeSink sink(output);
    try {
      bake_movmf(device, inputs, fitting_settings(job), sink, report, progress);
    } catch (const Cancelled&) {
      if (job.resume && checkpoint != nullptr) checkpoint->leave();
      throw;
    }
    if (checkpoint != nullptr) report.rows_resumed = checkpoint->rows_resumed();
  }
  clock.finish("fit");
  warn_of_sharp_lobes(job, header, report);
  if (meter) {
    progress_stage(progress, "measure");
    report.accuracy = meter->run(device, normals, inputs.albedo, progress);
    clock.finish("measure");
  }
  progress_advance(progress, level_units);
  progress_stage(progress, "write");
  writer.commit(measured_error_json(report.accuracy), progress);
  clock.finish("write");
  report.launches = launches_since(launches_before, device);
  report.programs_built = device.program_count() - programs_before;
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
