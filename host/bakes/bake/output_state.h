// SPDX-License-Identifier: Apache-2.0
// Recognises an output that the same bake has already made: by the program's version and kernels, every setting that
// changes the file, and the contents of what was read. Times of files say nothing: a fresh checkout has new ones.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/bake_job.h"

namespace multum {

/// Settings that JOB's texels are fitted with: its own, held to wrap modes: those of JOB, or of the map once it is read
/// (--wrap auto). A map that repeats is filtered across its border, so its lobes must be alike there.
MovmfSettings fitting_settings(const BakeJob& job, WrapMode wrap_s, WrapMode wrap_t);

/// Every setting that changes the file, the reading's too, hashes of the material's maps, and the kernels. Throws
/// Error(kInput) when one of them cannot be read.
std::string all_settings_json(const BakeJob& job);

/// Stands for what the rows of a bake depend on: what a killed bake left, or a share, is of use to no other. A line.
std::string rows_key(const BakedProvenance& from);

enum class OutputFinding {
  kInPlace,     // as this bake would make it; its header says so, its texels are not looked at
  kMissing,     // no file
  kUnreadable,  // no baked file, or its header is damaged
  kStale,       // baked from something else, otherwise, or by another program
};

struct OutputState {
  OutputFinding finding;
  std::string why;      // of kUnreadable and kStale
  StatedErrors stated;  // by the header of a file that is there and was measured
};

/// `settings`: all_settings_json(job). Throws Error(kInput) when there is a file to compare with, and the map cannot be
/// read.
OutputState find_output_state(const BakeJob& job, const std::string& settings);

}  // namespace multum
