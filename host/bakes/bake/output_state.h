// SPDX-License-Identifier: Apache-2.0
// Recognises an output that the same bake has already made: by the program's version and kernels, every setting that
// changes the file, and the contents of the inputs. File times are ignored, because a fresh checkout has new ones.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/bake_job.h"

namespace multum {

/// Settings that fit JOB's texels: JOB's own, restricted by the wrap modes of JOB or, with --wrap auto, of the map. A
/// map that repeats is filtered across its border, so its lobes must match there.
MovmfSettings fitting_settings(const BakeJob& job, WrapMode wrap_s, WrapMode wrap_t);

/// Every setting that changes the file: settings for reading and fitting, hashes of the material maps, and the kernels.
/// Throws Error(kInput) if one of the maps cannot be read.
std::string all_settings_json(const BakeJob& job);

/// Identifies the inputs of the rows of a bake, in one line. Rows of a killed bake or of a share can only be used with
/// an equal key.
std::string rows_key(const BakedProvenance& from);

enum class OutputFinding {
  kInPlace,     // equal to the result of this bake, by its header; texels are not read
  kMissing,     // no file
  kUnreadable,  // not a baked file, or its header is damaged
  kStale,       // baked from other inputs, with other settings or by another program
};

struct OutputState {
  OutputFinding finding;
  std::string why;      // reason for kUnreadable and kStale
  StatedErrors stated;  // errors stated in the header of an existing, measured file
};

/// `settings`: all_settings_json(job). Throws Error(kInput) if an output exists, but the map cannot be read for
/// comparison.
OutputState find_output_state(const BakeJob& job, const std::string& settings);

}  // namespace multum
