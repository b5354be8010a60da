// SPDX-License-Identifier: Apache-2.0
// Reads a bake's inputs, the map and its material's maps: into memory where they are small, else into scratch files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_report.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// How often a job goes through its maps: what it reads again and again stays in memory longer.
enum class MapReadings { kFew, kMany };

struct BakeSource {
  NormalMapRows map;
  std::optional<PlaneStore> albedo;                         // where the job has one
  std::optional<WeightMap> weights;                         // the same
  double mean_cosine = 1.0;                                 // of the roughness map
  std::optional<RoughnessReport> roughness = std::nullopt;  // of the file it was read from
  std::int64_t albedo_clamped = 0;                          // ColourRows::clamped_count
  std::vector<std::string> map_warnings = {};               // of albedo and weights, with the file's name
  std::string albedo_format = {};                           // ColourRows::format

  const PlaneStore* colours() const { return albedo ? &*albedo : nullptr; }
  FeaturePlanes features() const { return FeaturePlanes::of(colours(), weights ? &*weights : nullptr); }
  bool has_roughness() const { return map.normals.is_shortened(); }
};

/// The folder for what does not fit in memory: the job's, or the output's.
std::string scratch_folder(const BakeJob& job);

/// Header of the files that are baked from the source, all but their provenance.
BakedHeader baked_header_of(const BakeJob& job, const BakeSource& source);

/// BakedProvenance::reading: what was found in the files, and what was taken in doubt.
std::string reading_json(const BakeJob& job, const BakeSource& source);

/// Throws Error(kInput) for files that cannot be used.
BakeSource read_bake_source(const BakeJob& job, MapReadings readings, Progress* progress);
/// The same, and notes what was found in the log and in `report`.
BakeSource read_source(const BakeJob& job, MapReadings readings, BakeReport& report, Progress* progress);
/// Notes in the log what was found in the source's files.
void log_source(const BakeJob& job, const BakeSource& source);
/// Notes it in the report.
void note_source(const BakeSource& source, BakeReport& report);

}  // namespace multum
