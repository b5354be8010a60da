// SPDX-License-Identifier: Apache-2.0
#include "host/bake/bake_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/bake/accuracy_table.h"
#include "host/bake/movmf_bake.h"
#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/output_paths.h"
#include "host/image/reading_settings.h"
#include "kernels/kernel_sources.h"

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

// A map that repeats is filtered across its border, so its lobes must be alike there.
MovmfSettings fitting_settings(const BakeJob& job) {
  MovmfSettings settings = job.fitting;
  settings.periodic_x = job.reading.wrap_s == WrapMode::kPeriodic;
  settings.periodic_y = job.reading.wrap_t == WrapMode::kPeriodic;
  return settings;
}

// Every setting that changes the file, the reading's too, and the kernels: what an unchanged bake is recognised by.
std::string all_settings_json(const BakeJob& job) {
  nlohmann::json json = nlohmann::json::parse(settings_json(fitting_settings(job)));
  add_reading_settings(job.reading, json);
  json["encoding"] = storage_encoding_name(job.encoding);
  json["compression"] = job.writing.compression;
  json["albedo"] = job.albedo.empty() ? "" : hash_file(job.albedo);
  std::string kernels;
  for (const auto& [name, source] : kernel_sources()) kernels += source;
  json["kernels"] = hash_text(kernels).substr(0, 16);
  return json.dump();
}

const std::string kSoftware = std::string("multum ") + MULTUM_VERSION;

// Is the output there already, as this bake would make it? Anything else of that name is baked over, as ever.
bool is_baked(const BakeJob& job, const std::string& settings) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(job.output, none)) return false;
  try {
    const MovmfProvenance there = read_movmf_header(job.output).provenance;
    const auto measured = parse_measured_error(there.measured_error);
    return there.software == kSoftware && there.settings == settings &&
           (!job.measure || (measured && !measured->empty())) && there.source_hash == hash_file(job.input);
  } catch (const Error&) {
    return false;
  }
}

// Lobes sharper than the storage keeps: counted, and warned of where they stand for more of the map than this. Every
// map has some at level 1, around two or three normals that are nearly alike. Measured on the test folder, snorm16: 2
// to 28 % of ordinary maps, 36 to 57 % of surfaces with slopes of 0.01 rms, which only a glossy material shows.
constexpr double kBeyondStorageNoted = 1.0 / 3.0;

void count_beyond_storage(const BakeJob& job, const MovmfMipmap& mipmap, BakeReport& report) {
  double amplitude = 0.0, texels = 0.0;
  // Level 0 has single directions alone.
  for (std::size_t l = static_cast<std::size_t>(std::max(1, mipmap.first_level)); l < mipmap.levels.size(); ++l) {
    const MovmfLevel& level = mipmap.levels[l];
    const SharpLobes sharp = count_sharp_lobes(level, mipmap.encoding, job.threads);
    report.beyond_storage += sharp.count;
    amplitude += sharp.amplitude;
    texels += static_cast<double>(level.width) * level.height;
  }
  if (texels > 0.0) report.beyond_storage_share = amplitude / texels;
  if (report.beyond_storage_share <= kBeyondStorageNoted) return;
  const auto kappa_max = static_cast<double>(storage_kappa_max(mipmap.encoding));
  log_warning(fmt::format(
      "{}: {} lobes, which stand for {:.0f} % of the normals, are sharper than kappa {:.0f} and lose their spread in "
      "{}: highlights about as sharp (Blinn-Phong of s = {:.0f} and more) come out too sharp; {}",
      job.input, report.beyond_storage, 100.0 * report.beyond_storage_share, kappa_max,
      storage_encoding_name(mipmap.encoding), kappa_max,
      mipmap.encoding == StorageEncoding::kHalf ? "--data-format snorm16 keeps kappa up to 20000, float more"
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

}  // namespace

BakeReport bake_file(const BakeJob& job, Device& device, Progress* progress) {
  validate(job.fitting);
  validate(job.writing);
  check_paths_differ({job.input, job.albedo}, {job.output, job.report});
  check_output_name(job.output);
  check_writable(job.output);
  if (!job.report.empty()) check_writable(job.report);
  BakeReport report;
  report.source = std::filesystem::path(job.input).filename().string();
  const std::string settings = all_settings_json(job);
  if (!job.force && is_baked(job, settings)) {
    report.unchanged = true;
    if (!job.report.empty()) write_text_file(job.report, report.to_json());
    return report;
  }
  StageClock clock(report);
  const std::map<std::string, std::uint64_t> launches_before = device.launch_counts();
  const int programs_before = device.program_count();
  const NormalMap map = read_normal_map(job.input, job.reading, job.threads, progress);
  report.input = map.report;
  std::optional<ColourMap> albedo;
  if (!job.albedo.empty()) albedo = read_albedo_map(job.albedo, map.width, map.height, job.threads);
  log_info(fmt::format("{}: {} x {}, {}; {}", job.input, map.width, map.height, map.report.encoding,
                       map.report.encoding_reason));
  for (const std::string& warning : map.report.warnings) log_warning(job.input + ": " + warning);
  clock.finish("read");

  validate(job.fitting, map.width, map.height);
  // Measuring and writing count as about a level's work each.
  const std::uint64_t level_units =
      movmf_bake_units(map.width, map.height) / static_cast<std::uint64_t>(mip_level_count(map.width, map.height));
  progress_start(progress, movmf_bake_units(map.width, map.height, job.fitting.first_level) + 2 * level_units);
  MovmfMipmap mipmap = bake_movmf(device, map, albedo ? &*albedo : nullptr, fitting_settings(job), report, progress);
  mipmap.encoding = job.encoding;
  mipmap.wrap_s = job.reading.wrap_s;
  mipmap.wrap_t = job.reading.wrap_t;
  clock.finish("fit");
  count_beyond_storage(job, mipmap, report);
  quantize_movmf(mipmap, job.threads);
  clock.finish("round");
  if (job.measure) {
    progress_stage(progress, "measure");
    AccuracySettings accuracy;
    accuracy.threads = job.threads;
    accuracy.albedo = albedo ? &*albedo : nullptr;
    report.accuracy = measure_accuracy(device, mipmap, map, accuracy, progress);
    clock.finish("measure");
  }
  progress_advance(progress, level_units);
  progress_stage(progress, "write");
  mipmap.provenance.software = kSoftware;
  mipmap.provenance.source_name = report.source;
  mipmap.provenance.source_hash = hash_file(job.input);
  mipmap.provenance.settings = settings;
  mipmap.provenance.settings_hash = hash_text(mipmap.provenance.settings);
  mipmap.provenance.measured_error = measured_error_json(report.accuracy);
  write_movmf_mipmap(job.output, mipmap, job.writing, progress);
  clock.finish("write");
  report.launches = launches_since(launches_before, device);
  report.programs_built = device.program_count() - programs_before;
  if (!job.report.empty()) write_text_file(job.report, report.to_json());
  progress_finish(progress);
  return report;
}

}  // namespace multum
