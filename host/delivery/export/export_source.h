// SPDX-License-Identifier: Apache-2.0
// Reads the inputs of an export, which are the normals of its map or baked file, the other maps, and the lobes with
// which the export is compared.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "host/delivery/export/baked_lobes.h"
#include "host/delivery/export/export_job.h"
#include "host/foundation/base/files/input_hashes.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct ExportSource {
  NormalMapRows map;
  std::optional<PlaneStore> surface;  // set only for MapSurface::kInterpolated
  std::optional<LobeMaterial> material;
  std::unique_ptr<BakedLobes> lobes;    // null if there are no lobes to compare with
  std::unique_ptr<InputHashes> hashes;  // hashes of the input files, computed before reading

  /// The result points into the source, which must outlive it.
  OneLobeInputs inputs(const ExportJob& job) const;
  /// Levels 1 and coarser are fitted to these normals.
  const PlaneStore& fitted_normals() const { return surface ? *surface : map.normals; }
};

/// Reads all inputs and logs what they contain. `folder` is for data that does not fit in memory, unless the job names
/// a folder. Throws Error(kInput) for unusable files, and Cancelled.
ExportSource read_export_source(const ExportJob& job, const std::string& folder, Progress* progress);

}  // namespace multum
