// SPDX-License-Identifier: Apache-2.0
// Remembers what the files of an export were made of, in a file beside them, so that a run over a manifest makes anew
// what has changed alone. Times of files say nothing: a fresh checkout has new ones.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/export_job.h"

namespace multum {

enum class ExportFinding {
  kInPlace,  // made of these files with these settings by this program, and every byte is as it was written
  kMissing,  // no record, or a file is not there
  kStale,    // made of something else, otherwise, or by another program
  kDamaged,  // a file is not what was written
};

struct ExportState {
  ExportFinding finding = ExportFinding::kMissing;
  std::string why;
};

/// The hidden file that has the record: FOLDER/.multum-export, or .NAME.multum-export beside NAME_normal.ktx2.
std::string export_record_file(const ExportJob& job);

/// Throws Error(kInput) when there is a record, and a file that the job reads cannot be read.
ExportState find_export_state(const ExportJob& job);

/// After an export. Throws Error(kInput, kEnvironment).
void write_export_record(const ExportJob& job, const ExportReport& report);

}  // namespace multum
