// SPDX-License-Identifier: Apache-2.0
// Reads what an export is made of: the normals of its map or baked file, the maps beside them, and lobes to compare
// with.
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
  std::optional<PlaneStore> surface;  // of MapSurface::kInterpolated
  std::optional<LobeMaterial> material;
  std::unique_ptr<BakedLobes> lobes;    // null: none to compare with
  std::unique_ptr<InputHashes> hashes;  // of its files, noted before they were read

  /// They look at the source, which must outlive them.
  OneLobeInputs inputs(const ExportJob& job) const;
  /// Levels from 1 on are fitted to these.
  const PlaneStore& fitted_normals() const { return surface ? *surface : map.normals; }
};

/// `folder`: for what does not fit in memory, unless the job names one. Throws Error(kInput) for files that cannot be
/// used, Cancelled. Notes what was found in the log.
ExportSource read_export_source(const ExportJob& job, const std::string& folder, Progress* progress);

}  // namespace multum
