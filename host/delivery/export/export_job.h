// SPDX-License-Identifier: Apache-2.0
// An export from file to file: a normal map or height field, with a material's other maps, to a material of one lobe a
// texel that engines load.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/delivery/export/accuracy/export_accuracy.h"
#include "host/delivery/export/formed_material.h"
#include "host/delivery/export/material_folder.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/files/input_hashes.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct ExportJob {
  std::string input;  // a normal map or height field; or NAME.ndf.exr, whose level 0 is the map
  std::string lobes;  // a baked file of the map, whose lobes are measured beside; empty: `input` where it is one
  std::string roughness, occlusion, metalness;  // FILE or FILE:CHANNEL; empty: none
  bool roughness_is_gloss = false;
  std::string output;  // a folder; or NAME.ktx2, NAME.dds for files NAME_normal.ktx2 and so on
  std::string report;  // JSON; empty: none
  NormalMapSettings reading;
  MapSurface surface = MapSurface::kTexels;  // of levels from 1 on
  OneLobeSettings lobe;
  std::optional<MaterialForm> form;        // unset: one lobe
  Engine engine = Engine::kThree;          // whose pictures choose it
  std::optional<MaterialFormat> format;    // unset: by the output's name, else PNG
  std::optional<MaterialTexels> texels;    // unset: half floats in EXR, else RGBA8
  int zstd_level = 0;                      // of KTX2 files, 1..kZstdLevelMax; 0: not supercompressed
  bool has_roughness_alone = false;        // instead of occlusion, roughness and metalness in one texture
  bool has_smoothness = false;             // 1 - roughness, as Unity reads it
  GreenAxis write_green = GreenAxis::kUp;  // of what is written; `reading` has that of the map
  int uastc_effort = 1;                    // of MaterialTexels::kUastc
  std::string encoder;                     // UastcSettings::encoder
  bool measure = true;
  ExportAccuracySettings accuracy;
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;  // for buffers and for the maps; changes no byte
  std::string scratch_folder;                             // for what does not fit; empty: the output's
  int threads = 1;
  bool force = false;   // of a manifest: also where what is there is in place
  bool resume = false;  // keep what is fitted while it runs, and go on from what a stopped export of the same left
};

/// Maps beside the normals, and a bake of them.
constexpr std::string ExportJob::*kExportMapsBeside[] = {&ExportJob::roughness, &ExportJob::occlusion,
                                                         &ExportJob::metalness, &ExportJob::lobes};

/// Whether and how levels get another form than the fit. `scratch_folder`: for what does not fit in memory, unless the
/// job names one.
FormSettings form_settings(const ExportJob& job, const std::string& scratch_folder);

/// The files that an export reads, the map first; of FILE:CHANNEL the file.
std::vector<std::string> input_files(const ExportJob& job);

/// What ExportJob::output names: files in a folder, whose names begin with "STEM_" where it is NAME.ktx2 or NAME.dds.
struct ExportPlace {
  std::string folder, stem;
  std::optional<MaterialFormat> format;  // by the name
};
/// Throws Error(kUsage) for the name of one image.
ExportPlace export_place(const std::string& output);

struct ExportReport {
  int width = 0, height = 0, level_count = 0;
  NormalMapReport input;
  std::optional<RoughnessReport> roughness;
  std::string device, plan;
  std::uint64_t rows_resumed = 0;  // rows of levels that a stopped export had fitted
  std::string textures;            // "normal, orm"
  std::vector<std::string> files;
  std::vector<std::string> engines_failing;  // host/delivery/export/engine_support.h
  std::string engine_line;                   // the same as a text, "" where there are none
  std::vector<std::string> side_warnings;    // of readers that sides do not suit
  std::optional<ChosenForm> form;            // of MaterialForm::kAuto
  ExportAccuracy accuracy;
  std::map<std::string, std::uint64_t> launches;        // by kernel
  std::vector<std::pair<std::string, double>> seconds;  // by stage

  std::string to_json(const ExportJob& job) const;
};

/// Throws Error, Cancelled; leaves no partial file. Progress: a unit a texel of the map.
ExportReport export_file(const ExportJob& job, Device& device, Progress* progress);

}  // namespace multum
