// SPDX-License-Identifier: Apache-2.0
// Implements the steps that the bakes of all representations share. These steps round and write rows, measure the error
// and commit the file at the end, and verify a file row by row.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/asset/baked_verify.h"

namespace multum {

/// A sink for plain averages. It rounds rows for storage, passes them to the measurement if errors are measured, and
/// writes them.
template <typename Sink, typename Level, typename Writer, typename Meter>
class RoundingSink : public Sink {
 public:
  using Round = void (*)(Level& rows, StorageEncoding encoding, int threads);

  /// `meter` is null if nothing is measured.
  RoundingSink(Round round, Writer& writer, Meter* meter, const BakeJob& job)
      : round_(round), writer_(writer), meter_(meter), encoding_(job.encoding), threads_(job.threads) {}

  void add_level(int level, int first_row, Level rows) override {
    round_(rows, encoding_, threads_);
    if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
    writer_.write_level(level, first_row, std::move(rows));
  }

 private:
  const Round round_;
  Writer& writer_;
  Meter* const meter_;
  const StorageEncoding encoding_;
  const int threads_;
};

/// Returns the inputs of a bake of averages. `waiting_bytes` is the memory that its writer needs
/// (memory_beside_writer()).
inline AverageInputs average_inputs(const BakeRun& run, std::uint64_t waiting_bytes) {
  AverageInputs inputs{run, run.header.first_level};
  inputs.memory_bytes = memory_beside_writer(run, waiting_bytes);
  return inputs;
}

/// Returns the settings for measuring a bake's error. BakeJob::highlights follow the BRDFs that are measured for every
/// map.
inline AccuracySettings accuracy_settings(const BakeJob& job) {
  AccuracySettings settings;
  settings.threads = job.threads;
  settings.exponents = job.measured_exponents;
  settings.highlights = job.highlights;
  settings.has_level_table = job.measure_levels;
  settings.first_level = first_measured_level(job);
  return settings;
}

/// Removes the errors of BakeJob::highlights, so that the errors remain that every file states.
template <typename Measured>
std::vector<Measured> stated(const BakeJob& job, std::vector<Measured> all) {
  for (const Highlight& one : job.highlights)
    std::erase_if(all, [&id = one.id](const Measured& measured) { return measured.brdf.is_same_brdf(id); });
  return all;
}

/// A writer that discards its rows, for bakes that are only measured.
struct NoFile {
  template <typename Rows>
  void write_level(int, int, const Rows&) {}
};

/// Finishes the file after the last row, and measures its error unless `meter` is null. The measurement counts as
/// `measure_units` of progress.
template <typename Writer>
void measure_and_commit(const BakeRun& run, AccuracyMeter* meter, std::uint64_t measure_units, Writer& writer,
                        BakeReport& report, Progress* progress) {
  if (meter != nullptr) {
    progress_stage(progress, "measure");
    report.accuracy = meter->run(run.device, run.source.map.normals, run.source.colours(), progress);
    report.error = meter->footprint_errors();
    run.clock.finish("measure");
  }
  progress_advance(progress, measure_units);
  progress_stage(progress, "write");
  writer.commit(measured_error_json(stated(run.job, report.accuracy), stated(run.job, report.error)), progress);
  run.clock.finish("write");
}

/// Implements NdfBake::verify with verify_movmf(), verify_moments() or verify_sh(), and passes the rows to `meter`.
template <typename Level, typename Meter, typename Verify>
VerifiedFile verify_by_rows(Verify verify_file, const BakeJob& job, std::unique_ptr<Meter> meter, Progress* progress) {
  const auto seen = [&](int level, int first_row, const Level& rows) {
    meter->add_rows(level, first_row, rows);
    progress_advance(progress, static_cast<std::uint64_t>(rows.height));
  };
  std::vector<VerifyFinding> findings = verify_file(job.output, job.threads, seen);
  return {std::move(findings), std::move(meter)};
}

}  // namespace multum
