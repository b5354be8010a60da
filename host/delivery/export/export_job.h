// SPDX-License-Identifier: Apache-2.0
// Exports the file of a normal map or height field, together with a material's other maps. The result is a material
// with one lobe per texel, which engines can load.
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
#include "host/formats/image/plane_mosaic.h"
#include "host/formats/image/surface_points.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/files/input_hashes.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct ExportJob {
  std::string input;  // a normal map, a height field, or NAME.ndf.exr, whose level 0 is the map
  std::string lobes;  // baked file whose lobes are also measured; if empty, `input` is used if it is a baked file
  std::string roughness, occlusion, metalness;  // FILE or FILE:CHANNEL; empty if there is no such map
  bool roughness_is_gloss = false;
  std::string output;  // a folder, or NAME.ktx2 or NAME.dds for files NAME_normal.ktx2 and so on
  std::string report;  // JSON file; empty if no report is written
  NormalMapSettings reading;
  MapSurface surface = MapSurface::kTexels;  // surface to which levels 1 and coarser are fitted
  OneLobeSettings lobe;
  std::optional<MaterialForm> form;      // one lobe if not set
  std::optional<Engine> engine;          // engine that will load the files; its pictures choose the form
  std::optional<MaterialFormat> format;  // if not set, see format_of()
  std::optional<MaterialTexels> texels;  // if not set, see stored_texels()
  std::optional<int> zstd_level;         // Zstandard level of KTX2 files, 1..kZstdLevelMax. If 0, files are not
                                         // supercompressed. If not set, the engine's preset decides
  MaterialPacking packing = MaterialPacking::kOrm;
  TextureNames names = TextureNames::kPlain;
  SideRule sides = SideRule::kAny;
  GreenAxis write_green = GreenAxis::kUp;  // green axis of written files; `reading` has the map's own axis
  int uastc_effort = 1;                    // effort of MaterialTexels::kUastc
  std::string encoder;                     // see UastcSettings::encoder
  bool measure = true;
  bool keeps_mosaic = false;  // fill ExportReport::mosaic
  ExportAccuracySettings accuracy;
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;  // memory for buffers and maps; does not change the result
  // Folder for data that does not fit in memory. If empty, the output folder is used.
  std::string scratch_folder;
  int threads = 1;
  bool force = false;  // for manifests: also export maps whose files are up to date
  // If true, fitted rows are kept during the run, and an export that was stopped continues from its fitted rows.
  bool resume = false;
};

/// Paths of the other maps, and of a bake of the normals.
constexpr std::string ExportJob::*kExportMapsBeside[] = {&ExportJob::roughness, &ExportJob::occlusion,
                                                         &ExportJob::metalness, &ExportJob::lobes};

/// Returns the settings for choosing the form of levels. `scratch_folder` is for data that does not fit in memory,
/// unless the job names a folder.
FormSettings form_settings(const ExportJob& job, const std::string& scratch_folder);

/// Returns the files that an export reads, the map first. FILE:CHANNEL counts as FILE.
std::vector<std::string> input_files(const ExportJob& job);

/// The folder that ExportJob::output names. If the output is NAME.ktx2 or NAME.dds, also the prefix "NAME_" of its
/// files.
struct ExportPlace {
  std::string folder, stem;
  std::optional<MaterialFormat> format;  // format that follows from the name
};
/// Throws Error(kUsage) if the output is the name of a single image.
ExportPlace export_place(const std::string& output);

/// Returns the file type that follows from the output's name, the job's format, the engine's preset, or PNG, in this
/// order.
MaterialFormat format_of(const ExportJob& job);
/// Returns the job's texels, those of the engine's preset if the file type can store them, or else half floats in EXR
/// and RGBA8 in other files.
MaterialTexels stored_texels(const ExportJob& job);

struct ExportReport {
  int width = 0, height = 0, level_count = 0;
  NormalMapReport input;
  std::optional<RoughnessReport> roughness;
  std::string device, plan;
  std::uint64_t rows_resumed = 0;  // rows that a stopped export had fitted
  std::string textures;            // names of the textures, such as "normal, orm"
  std::vector<std::string> files;
  std::vector<std::string> engines_failing;  // engines that cannot load the files
                                             // (host/delivery/export/engines/engine_support.h)
  std::string engine_line;                   // the same engines as one line of text; empty if there are none
  std::string preset_line;                   // the settings of the engine's preset; empty without an engine
  std::vector<std::string> side_warnings;    // warnings about readers that do not support textures of this size
  std::optional<ChosenForm> form;            // set only for MaterialForm::kAuto
  ExportAccuracy accuracy;
  std::shared_ptr<const MapMosaic> mosaic;              // set if ExportJob::keeps_mosaic is true
  std::map<std::string, std::uint64_t> launches;        // number of launches per kernel
  std::vector<std::pair<std::string, double>> seconds;  // seconds per stage

  std::string to_json(const ExportJob& job) const;
};

/// Throws Error and Cancelled. Leaves no partial file. Progress: one unit per texel of the map.
ExportReport export_file(const ExportJob& job, Device& device, Progress* progress);

}  // namespace multum
