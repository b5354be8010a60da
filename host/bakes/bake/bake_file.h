// SPDX-License-Identifier: Apache-2.0
// Bakes a map file to a baked file. A bake reads the map, fits or averages it, rounds the result, measures its error
// and writes it. The command line and the service call these functions.
#pragma once

#include <vector>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_report.h"
#include "host/bakes/bake/bake_source.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Checks a job as far as possible without reading files. Throws Error(kUsage, kEnvironment).
void check_job(const BakeJob& job);

/// Bakes a job. The output appears when the bake is complete, or not at all. If the output was already baked from the
/// same file with the same settings, does nothing (BakeReport::unchanged), unless JOB.force is set. `source` is the
/// result of read_bake_source() for this job. If it is null, this function reads the source. Throws Error and
/// Cancelled.
BakeReport bake_file(const BakeJob& job, const BakeSource* source, Device& device, Progress* progress);

/// Lets several bakes run at the same time in this process, with the memory and the threads of the first job. Sets
/// BakeJob::memory_gate of every job, and returns the number of bakes at the same time, which is 1 if the memory
/// suffices only for one bake. There must be at least one job.
int share_memory(const std::vector<BakeJob*>& jobs);

/// Returns the report for an output that is not baked again, and writes BakeJob::report.
BakeReport unchanged_report(const BakeJob& job);

}  // namespace multum
