// SPDX-License-Identifier: Apache-2.0
// Lists the bakes of all representations. Each row (NdfBake) holds the steps of a bake (host/bakes/bake/bake_file.h)
// that differ between representations.
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

/// Appends a stage to the report, with the time since construction or since the previous stage.
class StageClock {
 public:
  explicit StageClock(BakeReport& report) : report_(report) {}
  void finish(const std::string& name) { report_.stages.push_back({name, stopwatch_.lap()}); }

 private:
  BakeReport& report_;
  Stopwatch stopwatch_;
};

/// One bake with its source: the inputs, the available memory and the job's settings.
struct BakeRun : MapInputs {
  const BakeJob& job;
  Device& device;
  const BakeSource& source;
  BakedHeader header;     // header of the output file
  MovmfSettings fitting;  // fitting_settings() for the map
  StageClock& clock;
};

/// Inputs of a bake from its job and source, within `memory_bytes`.
MapInputs map_inputs(const BakeJob& job, const BakeSource& source, std::uint64_t memory_bytes);

/// Returns the bytes that the writer holds per level until a row of tiles is full. A texel has `value_count` values.
/// The result includes the buffers for conversion from float to half.
std::uint64_t tile_row_bytes(const BakedHeader& header, int level, int tile_size, std::uint64_t value_count);
/// Returns the sum of these bytes over all levels, for bakes that compute all levels at once.
std::uint64_t tile_rows_bytes(const BakedHeader& header, int tile_size, std::uint64_t value_count);
/// Returns the bytes that remain for windows and buffers if rows of tiles use `waiting_bytes`. A default amount is
/// already reserved for every bake (bake_file.cpp), but wide maps need more. Throws Error(kUsage) that names --memory
/// if too little remains.
std::uint64_t memory_beside_writer(const BakeRun& run, std::uint64_t waiting_bytes);

/// The findings about a file and a meter that has read the file's rows.
struct VerifiedFile {
  std::vector<VerifyFinding> findings;
  std::unique_ptr<AccuracyMeter> meter;
};

struct NdfBake {
  Representation representation;
  /// Checks settings before any file is read. Throws Error(kUsage) for values out of range.
  void (*check_settings)(const BakeJob& job);
  /// Settings that change texels, as a JSON object.
  std::string (*settings)(const BakeJob& job);
  /// Throws Error(kInput) or Error(kUsage) for a map that cannot be baked with the settings.
  void (*check_map)(const BakeJob& job, int width, int height);
  /// Bakes the map, measures the error if the job asks for it, and writes JOB.output. Fills `report`, except for fields
  /// common to all bakes.
  void (*bake)(const BakeRun& run, BakeReport& report, Progress* progress);
  /// Bakes and rounds as `bake` does, writes nothing, and returns a meter that has read all rows. Works for maps that
  /// fit into memory. Reports the bake's time as stage "fit" or "average".
  std::unique_ptr<AccuracyMeter> (*try_bake)(const BakeRun& run, const AccuracySettings& accuracy, BakeReport& report,
                                             Progress* progress);
  /// Verifies JOB.output. Throws Error(kInput) if it cannot be read. Progress: one unit per row.
  VerifiedFile (*verify)(const BakeJob& job, const AccuracySettings& accuracy, Progress* progress);
};

const NdfBake& ndf_bake(Representation representation);

/// Tries a job on a map that fits into memory. Bakes level `accuracy.first_level` and coarser levels, or only the
/// levels from the job's first level on if that is coarser. No level depends on a finer one.
std::unique_ptr<AccuracyMeter> try_levels(Device& device, BakeJob job, const BakeSource& source,
                                          AccuracySettings accuracy, BakeReport& report, Progress* progress);

// The rows of the list. Each is defined in its own file: movmf_file_bake.cpp, moment_file_bake.cpp, sh_file_bake.cpp.
extern const NdfBake kMovmfBake;
extern const NdfBake kGmmBake;  // also in movmf_file_bake.cpp, for another family of lobes
extern const NdfBake kMomentBake;
extern const NdfBake kShBake;

}  // namespace multum
