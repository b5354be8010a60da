// SPDX-License-Identifier: Apache-2.0
// Checks that a finished file is whole and as near to its source as it states: verifies it as `multum verify` does, and
// measures it again as the bake did (docs/evidence/ACCURACY.md): the same texels, lights, views and BRDFs, so the same
// figures where nothing has changed.
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
  std::string damage;     // the first finding; empty: the file is whole
  StatedErrors measured;  // none where it is damaged
};

/// Checks JOB.output against JOB.input; writes nothing but scratch files. Throws Error(kInput) when the source cannot
/// be read, Cancelled. Memory: rows of tiles of the file and bands of the source.
BakedCheck check_baked_file(const BakeJob& job, Device& device, Progress* progress);

/// The largest error of pixels of all BRDFs; none without any.
std::optional<double> worst_error(const std::vector<FootprintError>& errors);

/// Names the error that exceeds what `stated` says by most, beyond what rounding explains, or that is not stated at
/// all; empty where there is none. Errors of pixels come before those of levels; where none are stated, as in files of
/// earlier programs, they are not held to anything.
std::string worse_than_stated(const StatedErrors& measured, const StatedErrors& stated);

}  // namespace multum
