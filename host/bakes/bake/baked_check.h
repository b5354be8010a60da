// SPDX-License-Identifier: Apache-2.0
// Checks that a finished file is undamaged and that its error is no larger than stated. Verifies it as `multum verify`
// does and measures it again as the bake did (docs/evidence/ACCURACY.md). The texels, lights, views and BRDFs are the
// same, so the errors of an unchanged file are the same.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/bake_job.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct BakedCheck {
  std::string damage;     // the first finding; empty if the file is undamaged
  StatedErrors measured;  // empty if the file is damaged
};

/// Checks JOB.output against JOB.input. Writes only scratch files. Throws Error(kInput) if the source cannot be read,
/// and Cancelled. The memory holds only rows of the file's tiles and bands of the source.
BakedCheck check_baked_file(const BakeJob& job, Device& device, Progress* progress);

/// Returns the largest pixel error of all BRDFs, or nullopt if there is none.
std::optional<double> worst_error(const std::vector<FootprintError>& errors);

/// Names an error that is missing from `stated`, or else the error that exceeds its value in `stated` by the largest
/// amount. Differences due to rounding are ignored. The result is empty if there is no such error. Pixel errors come
/// before errors of levels. Files of earlier program versions state no pixel errors, so their pixel errors are not
/// compared.
std::string worse_than_stated(const StatedErrors& measured, const StatedErrors& stated);

}  // namespace multum
