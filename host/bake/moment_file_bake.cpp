// SPDX-License-Identifier: Apache-2.0
// Bakes of moments, from file to file.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/asset/moment_file.h"
#include "host/asset/moment_verify.h"
#include "host/bake/accuracy_table.h"
#include "host/bake/box_pyramid.h"
#include "host/bake/moment_bake.h"
#include "host/bake/ndf_bake.h"
#include "host/base/error.h"
#include "host/base/log.h"

namespace multum {
namespace {

// Slopes that are cut off change the moments of all coarser texels. Of 32 real maps one has 0.8 % of such normals
// (asphalt, noise of every steepness), six a handful and the others none.
constexpr double kLimitedNoted = 0.01;

// Rounded, to the measurement and out.
class FileSink : public MomentSink {
 public:
  FileSink(MomentWriter& writer, MomentMeter* meter, StorageEncoding encoding, int threads)
      : writer_(writer), meter_(meter), encoding_(encoding), threads_(threads) {}

  void add_level(int level, int first_row, MomentLevel rows) override {
    quantize_moments(rows, encoding_, threads_);
    if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
    writer_.write_level(level, first_row, std::move(rows));
  }

 private:
  MomentWriter& writer_;
  MomentMeter* meter_;
  const StorageEncoding encoding_;
  const int threads_;
};

void warn_of_limited_slopes(const BakeRun& run, const BakeReport& report) {
  const double share = static_cast<double>(report.slopes_limited) /
                       (static_cast<double>(run.header.width) * static_cast<double>(run.header.height));
  if (share <= kLimitedNoted) return;
  log_warning(fmt::format(
      "{}: {:.1f} % of the normals are steeper than slopes of {} (87 degrees) and count as that steep: LEAN shades too "
      "narrow a highlight there; --ndf vmf has no such limit",
      run.job.input, 100.0 * share, kSlopeMax));
}

void bake(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  // Measuring and writing count as about half as much work as averaging.
  const std::uint64_t texels =
      static_cast<std::uint64_t>(run.header.width) * static_cast<std::uint64_t>(run.header.height);
  progress_start(progress, 2 * texels);
  BakedWriteOptions writing = job.writing;
  writing.measured_error_bytes = kMomentErrorBytes;
  MomentWriter writer(job.output, run.header, writing);
  AccuracySettings accuracy;
  accuracy.threads = job.threads;
  std::optional<MomentMeter> meter;
  if (job.measure) meter.emplace(run.header, accuracy);
  FileSink sink(writer, meter ? &*meter : nullptr, job.encoding, job.threads);
  AverageInputs inputs;
  inputs.normals = &run.source.map.normals;
  inputs.albedo = run.source.colours();
  inputs.weights = run.source.weight_map();
  inputs.has_roughness = run.source.has_roughness;
  inputs.first_level = run.header.first_level;
  const auto values = static_cast<std::uint64_t>((run.header.has_colours ? 12 : 9) + run.header.weight_count);
  inputs.memory_bytes = memory_beside_writer(run, tile_rows_bytes(run.header, writing.tile_size, values));
  inputs.threads = job.threads;
  bake_moments(run.device, inputs, sink, report, progress);
  run.clock.finish("average");
  warn_of_limited_slopes(run, report);
  if (meter) {
    progress_stage(progress, "measure");
    report.accuracy = meter->run(run.device, run.source.map.normals, inputs.albedo, progress);
    run.clock.finish("measure");
  }
  progress_advance(progress, texels / 2);
  progress_stage(progress, "write");
  writer.commit(measured_error_json(report.accuracy), progress);
  run.clock.finish("write");
}

void check_settings(const BakeJob& job) {
  if (job.region.has_value() || !job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto are for --ndf vmf: moments of the whole map are averaged in less time than it is "
                "read");
}

std::string settings(const BakeJob& job) {
  const nlohmann::json json = {{"representation", representation_info(Representation::kMoments).name},
                               {"first_level", job.fitting.first_level},
                               {"slope_z_min", kSlopeZMin}};
  return json.dump();
}

VerifiedFile verify(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress) {
  auto meter = std::make_unique<MomentMeter>(read_moment_header(job.output), accuracy);
  const auto seen = [&](int level, int first_row, const MomentLevel& rows) {
    meter->add_rows(level, first_row, rows);
    progress_advance(progress, static_cast<std::uint64_t>(rows.height));
  };
  std::vector<VerifyFinding> findings = verify_moments(job.output, job.threads, seen);
  return {std::move(findings), std::move(meter)};
}

}  // namespace

const NdfBake kMomentBake = {
    Representation::kMoments,
    check_settings,
    settings,
    [](const BakeJob& job, int width, int height) { validate_box_map(job.fitting.first_level, width, height); },
    bake,
    verify,
};

}  // namespace multum
