// SPDX-License-Identifier: Apache-2.0
// Bakes from file to file: reads, fits or averages, rounds, measures, writes. The command line and the service call
// this.
#pragma once

#include "host/bake/bake_job.h"
#include "host/bake/bake_report.h"
#include "host/bake/bake_source.h"
#include "host/base/progress.h"
#include "host/opencl/device.h"

namespace multum {

/// Checks all of a job that can be checked before anything is read. Throws Error(kUsage, kEnvironment).
void check_job(const BakeJob& job);

/// Bakes JOB.output, which appears when all is done, or not at all. Does nothing when it is there already, from the
/// same file with the same settings (BakeReport::unchanged), unless JOB.force. Throws Error, Cancelled.
BakeReport bake_file(const BakeJob& job, Device& device, Progress* progress);
/// The same with the source that read_bake_source() has read already; null: reads it.
BakeReport bake_file(const BakeJob& job, const BakeSource* source, Device& device, Progress* progress);

/// Bakes from a source that has been read, whether the output is there or not (host/bake/bake_source.h).
BakeReport bake_source(const BakeJob& job, const BakeSource& source, Device& device, Progress* progress);

/// Reports an output that is left as it is, and writes BakeJob::report.
BakeReport unchanged_report(const BakeJob& job);

}  // namespace multum
