// SPDX-License-Identifier: Apache-2.0
// Bakes of spherical harmonics, from file to file.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/asset/sh_file.h"
#include "host/asset/sh_verify.h"
#include "host/bake/accuracy_table.h"
#include "host/bake/ndf_bake.h"
#include "host/bake/sh_bake.h"
#include "host/base/error.h"

namespace multum {
namespace {

// Rounded, to the measurement and out.
class FileSink : public ShSink {
 public:
  FileSink(ShWriter& writer, ShMeter* meter, StorageEncoding encoding, int threads)
      : writer_(writer), meter_(meter), encoding_(encoding), threads_(threads) {}

  void add_level(int level, int first_row, ShLevel rows) override {
    quantize_sh(rows, encoding_, threads_);
    if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
    writer_.write_level(level, first_row, std::move(rows));
  }

 private:
  ShWriter& writer_;
  ShMeter* meter_;
  const StorageEncoding encoding_;
  const int threads_;
};

// Rows that wait to be written, and texels that are looked at beyond what every bake is taken to need, of many
// coefficients each.
std::uint64_t waiting_bytes(const BakeRun& run, int tile_size, const ShMeter* meter) {
  constexpr std::uint64_t kUsualMeter = std::uint64_t{16} << 20;
  const std::uint64_t meter_bytes = meter != nullptr ? meter->kept_bytes() : 0;
  const int values = sh_coefficient_count(run.job.sh_order) + (run.header.has_colours ? 3 : 0);
  return tile_rows_bytes(run.header, tile_size, static_cast<std::uint64_t>(values)) +
         (meter_bytes > kUsualMeter ? meter_bytes - kUsualMeter : 0);
}

void bake(const BakeRun& run, BakeReport& report, Progress* progress) {
  const BakeJob& job = run.job;
  // Measuring and writing count as about half as much work as averaging.
  const std::uint64_t texels =
      static_cast<std::uint64_t>(run.header.width) * static_cast<std::uint64_t>(run.header.height);
  progress_start(progress, 2 * texels);
  BakedWriteOptions writing = job.writing;
  writing.tile_size = sh_tile_size(run.header.width, job.sh_order, writing.tile_size);
  ShWriter writer(job.output, run.header, job.sh_order, writing);
  AccuracySettings accuracy;
  accuracy.threads = job.threads;
  std::optional<ShMeter> meter;
  if (job.measure) meter.emplace(ShMipmap{run.header, job.sh_order, {}}, accuracy);
  FileSink sink(writer, meter ? &*meter : nullptr, job.encoding, job.threads);
  AverageInputs inputs;
  inputs.normals = &run.source.map.normals;
  inputs.albedo = run.source.colours();
  inputs.first_level = run.header.first_level;
  inputs.memory_bytes = memory_beside_writer(run, waiting_bytes(run, writing.tile_size, meter ? &*meter : nullptr));
  inputs.threads = job.threads;
  bake_sh(run.device, job.sh_order, inputs, sink, report, progress);
  run.clock.finish("average");
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
                "--region and --onto are for --ndf vmf: spherical harmonics of the whole map are averaged, not fitted");
  validate_sh_order(job.sh_order);
}

std::string settings(const BakeJob& job) {
  const nlohmann::json json = {{"representation", representation_info(Representation::kSh).name},
                               {"first_level", job.fitting.first_level},
                               {"sh_order", job.sh_order}};
  return json.dump();
}

VerifiedFile verify(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress) {
  auto meter = std::make_unique<ShMeter>(read_sh_header(job.output), accuracy);
  const auto seen = [&](int level, int first_row, const ShLevel& rows) {
    meter->add_rows(level, first_row, rows);
    progress_advance(progress, static_cast<std::uint64_t>(rows.height));
  };
  std::vector<VerifyFinding> findings = verify_sh(job.output, job.threads, seen);
  return {std::move(findings), std::move(meter)};
}

}  // namespace

const NdfBake kShBake = {
    Representation::kSh,
    check_settings,
    settings,
    [](const BakeJob& job, int width, int height) { validate_box_map(job.fitting.first_level, width, height); },
    bake,
    verify,
};

}  // namespace multum
