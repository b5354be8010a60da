// SPDX-License-Identifier: Apache-2.0
// Reads and runs an export manifest, a list of a project's maps with their export settings
// (docs/reference/manifests.md). Build pipelines keep the manifest next to the maps. A run exports only maps that have
// changed.
#pragma once

#include <string>
#include <vector>

#include "host/delivery/export/batch/export_record.h"
#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct ManifestExport {
  std::string name;  // output name in the manifest, with the tile if the map is part of a set
  ExportJob job;
};

/// Reads and validates a manifest. Each map's job is `pattern` with the manifest's settings. A set becomes one map per
/// tile. No other file is opened. Throws Error(kInput) that names the file, the line, the value found and the value
/// expected.
std::vector<ManifestExport> read_export_manifest(const std::string& path, const ExportJob& pattern);

struct ManifestExportResult {
  ExportState found;                   // state before this run
  std::optional<ExportReport> report;  // set if this run exported the map
};

/// Exports a map if its files are not up to date or if its job forces the export, and writes its record. If `is_dry` is
/// true, only checks the files. Throws Error and Cancelled.
ManifestExportResult run_manifest_export(const ManifestExport& map, bool is_dry, Device& device, Progress* progress);

}  // namespace multum
