// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/compared_bake.h"

#include <filesystem>

#include "host/bakes/bake/bake_file.h"
#include "host/foundation/base/messages/quiet_log.h"

namespace multum {

BakeJob compared_bake_job(const ExportJob& job, const std::string& output) {
  BakeJob bake;
  bake.input = job.input;
  bake.reading = job.reading;
  bake.surface = job.surface;
  if (job.surface == MapSurface::kInterpolated) bake.fitting.first_level = 1;
  bake.output = output;
  bake.memory_bytes = resident_memory_of(job.memory_bytes);
  bake.scratch_folder = job.scratch_folder;
  bake.threads = bake.writing.threads = job.threads;
  bake.measure = false;
  bake.force = true;
  return bake;
}

ComparedBake::ComparedBake(const ExportJob& job, const std::string& page, Device& device, Progress* progress) {
  work_ = WorkFolder::make(std::filesystem::path(page).parent_path().string());
  path_ = work_->path() + "/lobes.ndf.exr";
  const QuietLog quiet;  // the export already prints the warnings about the map
  bake_file(compared_bake_job(job, path_), nullptr, device, progress);
}

}  // namespace multum
