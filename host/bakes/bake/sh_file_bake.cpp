// SPDX-License-Identifier: Apache-2.0
// Bakes spherical harmonics from file to file.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/bakes/averages/sh_bake.h"
#include "host/bakes/bake/file_bake_steps.h"
#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/averages/sh_verify.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

template <typename Writer>
using ShFileSink = RoundingSink<ShSink, ShLevel, Writer, ShMeter>;

// Returns the memory for rows that wait to be written, and for measured texels beyond the amount that is reserved for
// every bake. More is needed because each texel has many coefficients.
std::uint64_t waiting_bytes(const BakeRun& run, int tile_size, const ShMeter* meter) {
  constexpr std::uint64_t kDefaultMeter = std::uint64_t{16} << 20;
  const std::uint64_t meter_bytes = meter != nullptr ? meter->kept_bytes() : 0;
  const int values =
      sh_coefficient_count(run.job.sh_order) + (run.header.has_colours ? 3 : 0) + run.header.weight_count;
  return tile_rows_bytes(run.header, tile_size, static_cast<std::uint64_t>(values)) +
         (meter_bytes > kDefaultMeter ? meter_bytes - kDefaultMeter : 0);
}

void bake_sh_file(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  // Measuring and writing together count as half the work of averaging.
  const std::uint64_t texels =
      static_cast<std::uint64_t>(run.header.width) * static_cast<std::uint64_t>(run.header.height);
  progress_start(progress, 2 * texels);
  BakedWriteOptions writing = job.writing;
  writing.tile_size = sh_tile_size(run.header.width, job.sh_order, writing.tile_size);
  ShWriter writer(job.output, run.header, job.sh_order, writing);
  std::optional<ShMeter> meter;
  if (job.measure) meter.emplace(ShMipmap{run.header, job.sh_order, {}}, accuracy_settings(job));
  ShFileSink<ShWriter> sink(quantize_sh, writer, meter ? &*meter : nullptr, job);
  const AverageInputs inputs = average_inputs(run, waiting_bytes(run, writing.tile_size, meter ? &*meter : nullptr));
  bake_sh(run.device, job.sh_order, inputs, sink, report.average, progress);
  run.clock.finish("average");
  measure_and_commit(run, meter ? &*meter : nullptr, texels / 2, writer, report, progress);
}

std::unique_ptr<AccuracyMeter> try_sh(const BakeRun& run, const AccuracySettings& accuracy, BakeReport& report,
                                      Progress* progress) {
  auto meter = std::make_unique<ShMeter>(ShMipmap{run.header, run.job.sh_order, {}}, accuracy);
  NoFile none;
  ShFileSink<NoFile> sink(quantize_sh, none, meter.get(), run.job);
  bake_sh(run.device, run.job.sh_order, average_inputs(run, 0), sink, report.average, progress);
  run.clock.finish("average");
  return meter;
}

void check_sh_settings(const BakeJob& job) {
  if (job.region.has_value() || !job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto work only with --ndf vmf, because spherical harmonics are averaged over the whole "
                "map, not fitted");
  validate_sh_order(job.sh_order);
}

std::string sh_settings(const BakeJob& job) {
  const nlohmann::json json = {{"representation", representation_info(Representation::kSh).name},
                               {"first_level", job.fitting.first_level},
                               {"sh_order", job.sh_order}};
  return json.dump();
}

VerifiedFile verify_sh_file(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress) {
  return verify_by_rows<ShLevel>(verify_sh, job, std::make_unique<ShMeter>(read_sh_header(job.output), accuracy),
                                 progress);
}

}  // namespace

const NdfBake kShBake = {
    Representation::kSh,
    check_sh_settings,
    sh_settings,
    [](const BakeJob& job, int width, int height) { validate_box_map(job.fitting.first_level, width, height); },
    bake_sh_file,
    try_sh,
    verify_sh_file,
};

}  // namespace multum
