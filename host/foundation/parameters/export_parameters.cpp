// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/export_parameters.h"

#include <utility>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;
using Rows = std::vector<Parameter>;

constexpr const char kExportRunGroup[] = "Running the export";
constexpr unsigned kExportJob = kOnCommandLine | kInManifest | kInService;

Parameter channel_parameter(const char* name, const char* help) {
  return {.name = name,
          .kind = Kind::kFile,
          .help = help,
          .unit = "FILE[:CHANNEL]",
          .group = kMaterialGroup,
          .surfaces = kExportJob};
}

Parameter storage_choice(const char* name, const char* default_text, std::vector<std::string> choices,
                         const char* help) {
  return {.name = name,
          .kind = Kind::kChoice,
          .help = help,
          .default_text = default_text,
          .choices = std::move(choices),
          .group = kStorageGroup,
          .surfaces = kExportJob};
}

Rows export_rows() {
  Parameter roughness = channel_parameter("roughness",
                                          "read the perceptual roughness of the surface (0 to 1) from the only "
                                          "channel, or else the green channel, of this map of the same size");
  Parameter gloss =
      channel_parameter("gloss", "read the gloss of the surface from this map of the same size; roughness = 1 - gloss");
  roughness.excludes = {"gloss", "base_roughness"};
  gloss.excludes = {"roughness", "base_roughness"};
  Parameter occlusion = channel_parameter(
      "occlusion", "also average the only channel, or else the red channel, of this occlusion map of the same size");
  Parameter metalness = channel_parameter(
      "metalness", "also average the only channel, or else the blue channel, of this metalness map of the same size");
  Parameter packing = storage_choice(
      "packing", "orm", choice_names(kMaterialPackings),
      "write occlusion, roughness and metalness in one texture (orm), metalness, occlusion, 1 and smoothness (1 - "
      "roughness) in one texture (mask), or one texture per map (separate, or smoothness with smoothness instead of "
      "roughness)");
  Parameter names = storage_choice(
      "names", "plain", choice_names(kTextureNames),
      "name the files rock_normal and rock_orm (plain), T_rock_N and T_rock_ORM (unreal), or rock_Normal and "
      "rock_MaskMap (unity)");
  Parameter sides = storage_choice("sides", "any", choice_names(kSideRules),
                                   "reject a map whose width or height an engine would not load with all levels");
  Parameter write_green = storage_choice("write_green", "up", choice_names(kGreenAxes),
                                         "write normals and directions of anisotropy with green up (OpenGL, glTF, "
                                         "Unity, Godot, Blender) or down (DirectX, "
                                         "Unreal); --green sets the direction in the input");
  return {{.name = "lobes",
           .help = "write the lobes of a baked file as a texture for GPUs, NAME.ktx2; can be combined only with "
                   "--texels, --zstd, --device, --force and --report",
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          {.name = "base_roughness",
           .kind = Kind::kNumber,
           .help = "set one perceptual roughness for the whole surface",
           .low = 0.0,
           .high = 1.0,
           .default_text = "0.5",
           .group = kMaterialGroup,
           .excludes = {"roughness", "gloss"},
           .surfaces = kExportJob},
          std::move(roughness),
          std::move(gloss),
          std::move(occlusion),
          std::move(metalness),
          lobe_anisotropy_parameter(kExportJob),
          fast_lobe_parameter(kExportJob),
          surface_parameter("; level 0 does not change", kExportJob),
          form_parameter("for each level the form with the lower error in pictures of a plane and a sphere", "one-lobe",
                         kExportJob),
          engine_parameter("write the files that this engine loads (see below)", kExportJob),
          {.name = "format",
           .kind = Kind::kChoice,
           .help = "set the file format: png (8 bits, one file per level), exr (half floats, one file per level), or "
                   "ktx2 or dds (one file per texture, with all levels)",
           .default_text = "from the name of the output, else png",
           .choices = choice_names(kMaterialFormats),
           .group = kStorageGroup,
           .surfaces = kExportJob},
          {.name = "texels",
           .kind = Kind::kChoice,
           .help = "set the texel format of KTX2 and DDS: rgba8, rgba16f (half floats), rg8, bc (compressed blocks) or"
                   " uastc (Basis Universal, only KTX2)",
           .default_text = "rgba16f for exr, bc for lobes, else rgba8",
           .choices = choice_names(kMaterialTexels),
           .group = kStorageGroup,
           .surfaces = kExportJob},
          {.name = "zstd",
           .kind = Kind::kInteger,
           .help = "compress KTX2 files without loss by Zstandard at this compression level (default: no compression)",
           .low = 1,
           .high = 19,
           .group = kStorageGroup,
           .surfaces = kExportJob},
          uastc_effort_parameter(kExportJob),
          encoder_parameter(kOnCommandLine),
          std::move(packing),
          std::move(names),
          std::move(sides),
          std::move(write_green)};
}

Rows export_run_rows() {
  Rows rows = {
      memory_parameter("use at most this much memory for buffers and maps; larger maps use a scratch file", 1.0, "256M",
                       kOnCommandLine | kInService),
      device_parameter(kOnCommandLine | kInService),
      {.name = "no_measure",
       .help = "do not measure the error of the output",
       .excludes = {"optimum", "beside"},
       .surfaces = kOnCommandLine},
      {.name = "optimum",
       .help = "also find the lowest error that any single lobe can have, which takes seconds per map",
       .excludes = {"no_measure"},
       .surfaces = kOnCommandLine},
      {.name = "beside",
       .kind = Kind::kFile,
       .help =
           "also measure the lobes of this baked file of the same map; the lobes of a baked input are always measured",
       .unit = "NAME.ndf.exr",
       .excludes = {"no_measure"},
       .surfaces = kOnCommandLine | kInManifest},
      {.name = "cells",
       .kind = Kind::kInteger,
       .help = "measure the error at this many texels in each of levels 2, 4 and 6",
       .low = 1,
       .high = 4096,
       .default_text = "16",
       .surfaces = kOnCommandLine},
      {.name = "report",
       .kind = Kind::kText,
       .help = "write times, counts, files and errors as JSON",
       .unit = "FILE",
       .surfaces = kOnCommandLine},
      {.name = "page",
       .kind = Kind::kText,
       .help = "compare the export with engine rules and baked lobes on a page with tables, pictures from three "
               "distances, and videos (if ffmpeg is installed)",
       .unit = "FILE.html",
       .surfaces = kOnCommandLine},
      {.name = "force",
       .help = "also export unchanged maps of a manifest; without a manifest, files are always written again",
       .surfaces = kOnCommandLine},
      {.name = "resume", .help = "store fitted rows, and continue an interrupted export", .surfaces = kOnCommandLine},
      {.name = "scratch",
       .kind = Kind::kText,
       .help = "write data that does not fit in memory to files in this folder",
       .unit = "FOLDER",
       .default_text = "the output",
       .surfaces = kOnCommandLine}};
  for (Parameter& row : rows) row.group = kExportRunGroup;
  return rows;
}

}  // namespace

const ParameterTable& export_parameters() {
  static const ParameterTable table = [] {
    Rows rows = export_rows();
    rows.push_back(input_parameter("input", bake_parameters().at("input").help, kInManifest | kInService));
    // An export reads maps like a bake does.
    for (Parameter& row : reading_parameters(kExportJob)) rows.push_back(std::move(row));
    for (Parameter& row : export_run_rows()) rows.push_back(std::move(row));
    return ParameterTable("export", std::move(rows));
  }();
  return table;
}

}  // namespace multum
