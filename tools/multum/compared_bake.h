// SPDX-License-Identifier: Apache-2.0
// Bakes the map of an export for the comparison on its page.
#pragma once

#include <memory>
#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

/// Returns the job that bakes the map of an export to `output`, with the memory limit and the scratch folder of the
/// export.
BakeJob compared_bake_job(const ExportJob& job, const std::string& output);

/// Bakes into a temporary file. The destructor removes the file.
class ComparedBake {
 public:
  /// Bakes into the folder of `page`. Throws the same errors as bake_file().
  ComparedBake(const ExportJob& job, const std::string& page, Device& device, Progress* progress);
  const std::string& path() const { return path_; }

 private:
  std::unique_ptr<WorkFolder> work_;
  std::string path_;
};

}  // namespace multum
