// SPDX-License-Identifier: Apache-2.0
// Describes a bake by its input files, output files and settings. host/bakes/bake/bake_file.h runs bakes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/highlight.h"
#include "host/bakes/bake/region_bake.h"
#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/map_shard.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/foundation/base/files/input_hashes.h"

namespace multum {

class MemoryGate;
class StartMemory;

struct BakeJob {
  std::string input;                // a normal map or height field
  std::string albedo;               // empty if the bake has no colours
  std::string roughness;            // FILE or FILE:CHANNEL (parse_channel_file); empty if there is none
  bool roughness_is_gloss = false;  // true if the file holds 1 - roughness
  std::string weights;              // weights of basis BRDFs, one channel each; empty if there are none
  std::string output;               // *.ndf.exr
  std::string report;               // JSON file; empty if no report is written
  NormalMapSettings reading;
  MapSurface surface = MapSurface::kTexels;  // kInterpolated is allowed only if the first level is at least 1, because
                                             // level 0 is the map itself
  Representation representation = Representation::kMovmf;
  int sh_order = 4;       // order of spherical harmonics, 1..20
  MovmfSettings fitting;  // settings for fitting lobes; the first level applies to every representation
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  BakedWriteOptions writing;
  bool measure = true;                                            // measure the error of the written file
  bool keeps_mosaic = false;                                      // fill BakeReport::mosaic
  std::vector<double> measured_exponents = {20.0, 100.0, 500.0};  // Blinn-Phong exponents s; Lambert is always measured
  std::vector<Highlight> highlights;                              // further highlights, measured for the report
  bool measure_levels = true;                                     // true to measure single levels in addition to pixels
  std::string chosen_for;          // target of chosen settings (target_key()), stored in the file; empty if no settings
                                   // were chosen
  bool stored_only = false;        // levels finer than the first stored one are neither shown nor measured
  bool force = false;              // bake even if the output was baked from the same file with the same settings
  std::uint64_t memory_bytes = 0;  // limit of resident memory; 0 means a quarter of the machine's memory
  std::string scratch_folder;      // folder for data that does not fit into memory; if empty, the output's folder is
                                   // used
  // Shared by bakes that run at the same time in this process. Each of them waits until its memory fits too. Null if no
  // other bake runs at the same time.
  std::shared_ptr<MemoryGate> memory_gate;
  bool resume = false;  // continue a killed bake of the same output
  // The share of the map that this process fits and writes to a file next to the output. This is only for lobes
  // (host/bakes/movmf/map_shard.h).
  std::optional<MapShard> shard;
  int merged_shards = 0;  // number of finished shares to merge into the output; if 0, all rows are fitted
  // If not empty, names the file that was baked before an edit. Only a region of the map is fitted again, and the
  // result is combined with this file. If `region` is not set, the region is the part of the map that has changed.
  std::string onto;
  std::optional<MapRegion> region;
  int threads = 2;  // number of threads for loops on the host
  // The memory that consecutive bakes of one map on one device share. If an earlier bake has found a start, this start
  // is reused, and the report states how long the search took (FitReport::start_remembered). If null, each bake
  // searches for its own start.
  std::shared_ptr<StartMemory> starts;
  // The hashes of the input files. Copies of a job share them, so that each file is hashed only once.
  std::shared_ptr<InputHashes> hashes = std::make_shared<InputHashes>();
};

/// The material maps, which are read together with the normals.
constexpr std::string BakeJob::*kMaterialMaps[] = {&BakeJob::albedo, &BakeJob::roughness, &BakeJob::weights};

/// Parses BakeJob::roughness, which must not be empty.
ChannelFile roughness_file(const BakeJob& job);

/// Returns the finest level whose error is measured. Finer levels are never shown, or contain the normal map's own
/// texels instead of points of the surface.
int first_measured_level(const BakeJob& job);

/// Returns BakeJob::memory_bytes for a command whose --memory limits only maps and buffers. The result is about 300 MiB
/// larger, to include the program, the OpenCL driver and the rows that wait to be written.
constexpr std::uint64_t resident_memory_of(std::uint64_t maps_and_buffers) {
  return maps_and_buffers + (std::uint64_t{512} << 20);
}

/// Returns the input files of a bake. The map is the first of them.
std::vector<std::string> input_files(const BakeJob& job);

}  // namespace multum
