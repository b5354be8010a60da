// SPDX-License-Identifier: Apache-2.0
// The page of an export: what it measured as tables, the surface drawn from three distances by every way to filter it,
// energy beside error, and moving pictures. One file that needs nothing else.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "host/delivery/export/export_job.h"
#include "host/delivery/export/report/surface_study.h"

namespace multum {

/// The files of templates/, by name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& export_templates();

/// Draws, encodes the moving pictures and writes JOB's page `path` atomically; `report` is that of the finished export.
/// Without ffmpeg there is a warning, and the page has the numbers of its motions alone. Throws Error, Cancelled.
void write_export_page(const ExportJob& job, const ExportReport& report, const std::string& path, Device& device,
                       Progress* progress);

/// The numbers of a study, for the page and for tests: distances and motions by the models' ids.
std::string study_json(const SurfaceStudy& study);

}  // namespace multum
