// SPDX-License-Identifier: Apache-2.0
// Reads the inputs of a bake, which are the map and its material maps. Small inputs are kept in memory, and larger ones
// in scratch files.
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

/// States whether a job reads its maps a few times or many times. If they are read many times, larger maps stay in
/// memory.
enum class MapReadings { kFew, kMany };

struct BakeSource {
  NormalMapRows map;
  std::optional<PlaneStore> albedo;                         // albedo, if the job has one
  std::optional<WeightMap> weights;                         // weights, if the job has them
  double mean_cosine = 1.0;                                 // mean cosine of the roughness map
  std::optional<RoughnessReport> roughness = std::nullopt;  // report about the roughness file
  std::int64_t albedo_clamped = 0;                          // ColourRows::clamped_count
  std::vector<std::string> map_warnings = {};               // warnings about albedo and weights; each names the file
  std::string albedo_format = {};                           // ColourRows::format

  const PlaneStore* colours() const { return albedo ? &*albedo : nullptr; }
  FeaturePlanes features() const { return FeaturePlanes::of(colours(), weights ? &*weights : nullptr); }
  bool has_roughness() const { return map.normals.is_shortened(); }
};

/// Returns the folder for data that does not fit into memory, which is the job's scratch folder or else the output
/// folder.
std::string scratch_folder(const BakeJob& job);

/// Returns the header of files that are baked from the source, without provenance.
BakedHeader baked_header_of(const BakeJob& job, const BakeSource& source);

/// Returns the properties that were found in the files, and the assumptions about unclear properties
/// (BakedProvenance::reading).
std::string reading_json(const BakeJob& job, const BakeSource& source);

/// Throws Error(kInput) for unusable files.
BakeSource read_bake_source(const BakeJob& job, MapReadings readings, Progress* progress);
/// Reads the source and notes its properties in the log and in `report`.
BakeSource read_source(const BakeJob& job, MapReadings readings, BakeReport& report, Progress* progress);
/// Writes the properties of the source's files to the log.
void log_source(const BakeJob& job, const BakeSource& source);
/// Copies the properties of the source's files to the report.
void note_source(const BakeSource& source, BakeReport& report);

}  // namespace multum
