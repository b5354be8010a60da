// SPDX-License-Identifier: Apache-2.0
// Checks that a finished file is undamaged and that its error is no larger than stated. Verifies it as `multum verify`
// does and measures it again as the bake did (docs/evidence/ACCURACY.md): with the same texels, lights, views and
// BRDFs, so that an unchanged file gives the same errors.
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

/// Checks JOB.output against JOB.input; writes only scratch files. Throws Error(kInput) if the source cannot be read,
/// Cancelled. Memory: rows of tiles of the file and bands of the source.
BakedCheck check_baked_file(const BakeJob& job, Device& device, Progress* progress);

/// The largest pixel error of all BRDFs; nullopt if there is none.
std::optional<double> worst_error(const std::vector<FootprintError>& errors);

/// Names the error that exceeds its value in `stated` by most, or that `stated` lacks. Rounding is ignored. Empty if
/// there is no such error. Errors of pixels come before errors of levels. Pixel errors are not compared for files of
/// earlier programs, which state none.
std::string worse_than_stated(const StatedErrors& measured, const StatedErrors& stated);

}  // namespace multum
