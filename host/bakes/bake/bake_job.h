// SPDX-License-Identifier: Apache-2.0
// Describes a bake: the files it reads and writes, and its settings. host/bakes/bake/bake_file.h runs it.
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

class StartMemory;

struct BakeJob {
  std::string input;                // a normal map or height field
  std::string albedo;               // empty: no colours
  std::string roughness;            // FILE or FILE:CHANNEL (parse_channel_file); empty: none
  bool roughness_is_gloss = false;  // that file holds 1 - roughness
  std::string weights;              // of basis BRDFs, a channel each; empty: none
  std::string output;               // *.ndf.exr
  std::string report;               // JSON file; empty: none
  NormalMapSettings reading;
  MapSurface surface = MapSurface::kTexels;  // kInterpolated: levels from 1 on alone, level 0 is the map
  Representation representation = Representation::kMovmf;
  int sh_order = 4;       // of spherical harmonics, 1..20
  MovmfSettings fitting;  // of lobes; its first level is that of every representation
  StorageEncoding encoding = StorageEncoding::kSnorm16;
  BakedWriteOptions writing;
  bool measure = true;                                            // measure the error of what is written
  std::vector<double> measured_exponents = {20.0, 100.0, 500.0};  // of highlights, Blinn-Phong s; Lambert always is
  std::vector<Highlight> highlights;                              // measured besides those, for the report alone
  bool measure_levels = true;                                     // each level by itself, besides pixels
  std::string
      chosen_for;  // what the settings were chosen for (target_key()), which the file then states; empty: nothing
  bool stored_only = false;        // levels finer than the first that is stored are never seen: not measured either
  bool force = false;              // bake even if the output is from the same file and settings
  std::uint64_t memory_bytes = 0;  // resident memory to stay within; 0: a quarter of the machine's
  std::string scratch_folder;      // for what does not fit; empty: the output's folder
  bool resume = false;             // go on from what a killed bake of the same output left
  // Of lobes: only one process's share is fitted, to a file beside the output (host/bakes/movmf/map_shard.h).
  std::optional<MapShard> shard;
  int merged_shards = 0;  // the bands of shares that are there, which make the output; 0: none, all is fitted
  // Not empty: only a part of the map is fitted again, onto that file, which was baked before the part was edited; the
  // part that has changed, where none is set.
  std::string onto;
  std::optional<MapRegion> region;
  int threads = 2;  // of the host's own loops
  // Of bakes of one map by one device, one after the other: a start that was searched is not searched again, and the
  // report says what that would have taken (FitReport::start_remembered). Null: each bake searches its own.
  std::shared_ptr<StartMemory> starts;
  // Of the files that are read. Copies of a job share it: each file is hashed once.
  std::shared_ptr<InputHashes> hashes = std::make_shared<InputHashes>();
};

/// Material maps, which are read along with the normals.
constexpr std::string BakeJob::*kMaterialMaps[] = {&BakeJob::albedo, &BakeJob::roughness, &BakeJob::weights};

/// BakeJob::roughness, which must not be empty.
ChannelFile roughness_file(const BakeJob& job);

/// The finest level whose error is measured: finer ones are never seen, or are the normal map's own and no points of
/// the surface.
int first_measured_level(const BakeJob& job);

/// BakeJob::memory_bytes where a command's own --memory is for maps and buffers alone: with the program and the OpenCL
/// driver, some 300 MiB, and rows that wait to be written.
constexpr std::uint64_t resident_memory_of(std::uint64_t maps_and_buffers) {
  return maps_and_buffers + (std::uint64_t{512} << 20);
}

/// The files that a bake reads, the map first.
std::vector<std::string> input_files(const BakeJob& job);

}  // namespace multum
