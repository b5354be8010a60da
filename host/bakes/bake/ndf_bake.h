// SPDX-License-Identifier: Apache-2.0
// Table of the representations' bakes: a row (NdfBake) holds the steps of a bake from file to file
// (host/bakes/bake/bake_file.h) that differ between representations.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_source.h"
#include "host/formats/asset/baked_verify.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {

/// Appends the time since its making, or since the last stage, to the report.
class StageClock {
 public:
  explicit StageClock(BakeReport& report) : report_(report) {}
  void finish(const std::string& name) { report_.stages.push_back({name, stopwatch_.lap()}); }

 private:
  BakeReport& report_;
  Stopwatch stopwatch_;
};

/// One bake, its source read: what is baked, in as much memory as there is, with whatever its job says.
struct BakeRun : MapInputs {
  const BakeJob& job;
  Device& device;
  const BakeSource& source;
  BakedHeader header;     // of the file to be
  MovmfSettings fitting;  // fitting_settings() of the map
  StageClock& clock;
};

/// What a job and its source give to a bake in so much memory.
MapInputs map_inputs(const BakeJob& job, const BakeSource& source, std::uint64_t memory_bytes);

/// Bytes that the writer holds of a level until a row of tiles is full, at `value_count` values per texel, with the
/// buffers that turn floats into halfs.
std::uint64_t tile_row_bytes(const BakedHeader& header, int level, int tile_size, std::uint64_t value_count);
/// Sum over all levels, for bakes that make them all at once.
std::uint64_t tile_rows_bytes(const BakedHeader& header, int tile_size, std::uint64_t value_count);
/// Bytes that are left for windows and buffers beside `waiting_bytes` of rows of tiles. The default amount is already
/// counted for every bake (bake_file.cpp); wide maps need more. Throws Error(kUsage) naming --memory when that leaves
/// too little.
std::uint64_t memory_beside_writer(const BakeRun& run, std::uint64_t waiting_bytes);

/// A file's findings, and a meter that has seen its rows.
struct VerifiedFile {
  std::vector<VerifyFinding> findings;
  std::unique_ptr<AccuracyMeter> meter;
};

struct NdfBake {
  Representation representation;
  /// Throws Error(kUsage) for settings out of range, before anything is read.
  void (*check_settings)(const BakeJob& job);
  /// Those settings that change texels, as a JSON object.
  std::string (*settings)(const BakeJob& job);
  /// Throws Error(kInput), Error(kUsage) for a map that cannot be baked with them.
  void (*check_map)(const BakeJob& job, int width, int height);
  /// Bakes, measures unless the job says no, and writes JOB.output. Fills `report` but for what every bake has.
  void (*bake)(const BakeRun& run, BakeReport& report, Progress* progress);
  /// Bakes and rounds as `bake` does, writes nothing, and returns a meter that has seen all rows. For maps that fit
  /// into memory. Its time is BakeReport's "fit" or "average".
  std::unique_ptr<AccuracyMeter> (*try_bake)(const BakeRun& run, const AccuracySettings& accuracy, BakeReport& report,
                                             Progress* progress);
  /// Verifies JOB.output. Throws Error(kInput) when it cannot be read. Progress: a unit a row.
  VerifiedFile (*verify)(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress);
};

const NdfBake& ndf_bake(Representation representation);

/// Tries a job on a map that fits into memory, from level `accuracy.first_level` on (or the job's, if that is coarser):
/// no level depends on a finer one.
std::unique_ptr<AccuracyMeter> try_levels(Device& device, BakeJob job, const BakeSource& source,
                                          AccuracySettings accuracy, BakeReport& report, Progress* progress);

// The rows, each in a file of its own: movmf_file_bake.cpp, moment_file_bake.cpp, sh_file_bake.cpp.
extern const NdfBake kMovmfBake;
extern const NdfBake kGmmBake;  // movmf_file_bake.cpp: lobes of another family
extern const NdfBake kMomentBake;
extern const NdfBake kShBake;

}  // namespace multum
