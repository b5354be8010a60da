// SPDX-License-Identifier: Apache-2.0
// Records the inputs of an export in a hidden file next to its outputs, so that a manifest run exports only maps that
// have changed. File times are ignored, because a fresh checkout has new ones.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"

namespace multum {

enum class ExportFinding {
  kInPlace,  // made by this program from these files with these settings, and unchanged since then
  kMissing,  // there is no record, or a file is missing
  kStale,    // made from other files, with other settings or by another program
  kDamaged,  // a file differs from the file that was written
};

struct ExportState {
  ExportFinding finding = ExportFinding::kMissing;
  std::string why;
};

/// Returns the path of the hidden record: FOLDER/.multum-export, or .NAME.multum-export next to NAME_normal.ktx2.
std::string export_record_file(const ExportJob& job);

/// Throws Error(kInput) if a record exists and a file that the job reads cannot be read.
ExportState find_export_state(const ExportJob& job);

/// Writes the record after an export. Throws Error(kInput) and Error(kEnvironment).
void write_export_record(const ExportJob& job, const ExportReport& report);

}  // namespace multum
