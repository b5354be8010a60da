// SPDX-License-Identifier: Apache-2.0
// Bakes from file to file: reads, fits or averages, rounds, measures, writes. The command line and the service call
// this.
#pragma once

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_report.h"
#include "host/bakes/bake/bake_source.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Checks all of a job that can be checked before anything is read. Throws Error(kUsage, kEnvironment).
void check_job(const BakeJob& job);

/// Bakes a job, whose output appears when all is done, or not at all. Nothing is done when it is there already, from
/// the same file with the same settings (BakeReport::unchanged), unless JOB.force. `source`: what read_bake_source()
/// has read of the job already; null: it is read here. Throws Error, Cancelled.
BakeReport bake_file(const BakeJob& job, const BakeSource* source, Device& device, Progress* progress);

/// Reports an output that is left as it is. Writes BakeJob::report.
BakeReport unchanged_report(const BakeJob& job);

}  // namespace multum
