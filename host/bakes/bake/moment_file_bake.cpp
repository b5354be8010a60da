// SPDX-License-Identifier: Apache-2.0
// Bakes moments from file to file.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/bakes/averages/moment_bake.h"
#include "host/bakes/bake/file_bake_steps.h"
#include "host/bakes/pyramid/box_pyramid.h"
#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/averages/moment_verify.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/option_words.h"

namespace multum {
namespace {

// Limited slopes change the moments of all coarser texels. Of 32 real maps, one has limited slopes at 0.8 % of its
// normals (asphalt, with noise of every steepness), six maps have a few, and the others have none.
constexpr double kLimitedNoted = 0.01;

template <typename Writer>
using MomentFileSink = RoundingSink<MomentSink, MomentLevel, Writer, MomentMeter>;

void warn_of_limited_slopes(const BakeRun& run, const AverageReport& report) {
  const double share = static_cast<double>(report.slopes_limited) /
                       (static_cast<double>(run.header.width) * static_cast<double>(run.header.height));
  if (share <= kLimitedNoted) return;
  log_warning(run.job.input, fmt::format("{:.1f} % of the normals have slopes above {} (87 degrees). They were limited "
                                         "to this slope, so LEAN draws their highlights too narrow{}",
                                         100.0 * share, kSlopeMax, advice("; <ndf vmf> has no such limit")));
}

void bake_moment_file(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  // Measuring and writing together count as half the work of averaging.
  const std::uint64_t texels =
      static_cast<std::uint64_t>(run.header.width) * static_cast<std::uint64_t>(run.header.height);
  progress_start(progress, 2 * texels);
  BakedWriteOptions writing = job.writing;
  writing.measured_error_bytes = kMomentErrorBytes;
  MomentWriter writer(job.output, run.header, writing);
  std::optional<MomentMeter> meter;
  if (job.measure) meter.emplace(run.header, accuracy_settings(job));
  MomentFileSink<MomentWriter> sink(quantize_moments, writer, meter ? &*meter : nullptr, job);
  const auto values = static_cast<std::uint64_t>((run.header.has_colours ? 12 : 9) + run.header.weight_count);
  const AverageInputs inputs = average_inputs(run, tile_rows_bytes(run.header, writing.tile_size, values));
  bake_moments(run.device, inputs, sink, report.average, progress);
  run.clock.finish("average");
  warn_of_limited_slopes(run, report.average);
  measure_and_commit(run, meter ? &*meter : nullptr, texels / 2, writer, report, progress);
}

std::unique_ptr<AccuracyMeter> try_moments(const BakeRun& run, const AccuracySettings& accuracy, BakeReport& report,
                                           Progress* progress) {
  auto meter = std::make_unique<MomentMeter>(run.header, accuracy);
  NoFile none;
  MomentFileSink<NoFile> sink(quantize_moments, none, meter.get(), run.job);
  bake_moments(run.device, average_inputs(run, 0), sink, report.average, progress);
  run.clock.finish("average");
  return meter;
}

void check_moment_settings(const BakeJob& job) {
  if (job.region.has_value() || !job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto work only with --ndf vmf, because averaging the moments of a whole map takes less "
                "time than reading the map");
}

std::string moment_settings(const BakeJob& job) {
  const nlohmann::json json = {{"representation", representation_info(Representation::kMoments).name},
                               {"first_level", job.fitting.first_level},
                               {"slope_z_min", kSlopeZMin}};
  return json.dump();
}

VerifiedFile verify_moment_file(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress) {
  return verify_by_rows<MomentLevel>(verify_moments, job,
                                     std::make_unique<MomentMeter>(read_moment_header(job.output), accuracy), progress);
}

}  // namespace

const NdfBake kMomentBake = {
    Representation::kMoments,
    check_moment_settings,
    moment_settings,
    [](const BakeJob& job, int width, int height) { validate_box_map(job.fitting.first_level, width, height); },
    bake_moment_file,
    try_moments,
    verify_moment_file,
};

}  // namespace multum
