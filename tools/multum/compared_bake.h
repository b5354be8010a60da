// SPDX-License-Identifier: Apache-2.0
// A bake of an export's map beside the export's page, to compare with.
#pragma once

#include <memory>
#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/delivery/export/export_job.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/files/work_folder.h"

namespace multum {

/// The bake of an export's map to `output`, with the export's memory and its folder for what does not fit.
BakeJob compared_bake_job(const ExportJob& job, const std::string& output);

/// The file goes when this does.
class ComparedBake {
 public:
  /// Beside `page`. Throws as bake_file() does.
  ComparedBake(const ExportJob& job, const std::string& page, Device& device, Progress* progress);
  const std::string& path() const { return path_; }

 private:
  std::unique_ptr<WorkFolder> work_;
  std::string path_;
};

}  // namespace multum
