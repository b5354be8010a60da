// SPDX-License-Identifier: Apache-2.0
// Recognises an output that an identical bake has already made. Compares the program's version and kernels, every
// setting that changes the file, and the contents of the inputs. Ignores file times, because a fresh checkout has new
// ones.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/bake_job.h"

namespace multum {

/// Returns the settings for fitting JOB's texels. They are JOB's own settings, adapted to the wrap modes of JOB or,
/// with --wrap auto, to those of the map. A map that repeats is filtered across its border, so its lobes must match
/// there.
MovmfSettings fitting_settings(const BakeJob& job, WrapMode wrap_s, WrapMode wrap_t);

/// Returns every setting that changes the file. These are the settings for reading and fitting, the hashes of the
/// material maps, and the kernels. Throws Error(kInput) if one of the maps cannot be read.
std::string all_settings_json(const BakeJob& job);

/// Returns one line that identifies the inputs of a bake's rows. Rows of a killed bake or of a share can be used only
/// if their key is equal.
std::string rows_key(const BakedProvenance& from);

enum class OutputFinding {
  kInPlace,     // the header is the one that this bake would write; texels are not compared
  kMissing,     // no file
  kUnreadable,  // not a baked file, or its header is damaged
  kStale,       // baked from other inputs, with other settings or by another program
};

struct OutputState {
  OutputFinding finding;
  std::string why;      // reason for kUnreadable and kStale
  StatedErrors stated;  // errors stated in the header of an existing, measured file
};

/// `settings` is all_settings_json(job). Throws Error(kInput) if an output exists but the map cannot be read for
/// comparison.
OutputState find_output_state(const BakeJob& job, const std::string& settings);

}  // namespace multum
