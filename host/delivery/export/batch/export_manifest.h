// SPDX-License-Identifier: Apache-2.0
// The list of a project's maps and how each is exported, which a build pipeline keeps in place: what has changed is
// exported again, all else is left alone (docs/reference/manifests.md).
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/batch/export_record.h"
#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct ManifestExport {
  std::string name;  // the output as the manifest names it, with its tile where it is one of a set
  ExportJob job;
};

/// Reads and validates a manifest; each map's job is `pattern` with what the manifest says. A set is as many maps as it
/// has tiles. No other file is looked at. Throws Error(kInput) that names the file, the line, what was found and what
/// was expected.
std::vector<ManifestExport> read_export_manifest(const std::string& path, const ExportJob& pattern);

struct ManifestExportResult {
  ExportState found;                   // before
  std::optional<ExportReport> report;  // set: exported in this run
};

/// Exports what is not in place, or whatever its job says is forced, and records it. `is_dry`: only looks. Throws
/// Error, Cancelled.
ManifestExportResult run_manifest_export(const ManifestExport& map, bool is_dry, Device& device, Progress* progress);

}  // namespace multum
