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

Rows export_rows() {
  Parameter roughness =
      channel_parameter("roughness",
                        "perceptual roughness of the surface itself, 0 to 1, of this map of the same size; of several "
                        "channels green");
  Parameter gloss = channel_parameter("gloss", "the same by a gloss map: roughness = 1 - gloss");
  roughness.excludes = {"gloss", "base_roughness"};
  gloss.excludes = {"roughness", "base_roughness"};
  Parameter occlusion =
      channel_parameter("occlusion", "average this map of the same size along; of several channels red");
  Parameter metalness =
      channel_parameter("metalness", "average this map of the same size along; of several channels blue");
  occlusion.excludes = metalness.excludes = {"roughness_alone"};
  Parameter roughness_alone = {.name = "roughness_alone",
                               .help =
                                   "write roughness as a texture of its own, of one channel in KTX2 and DDS, instead "
                                   "of orm, which has occlusion, roughness and metalness",
                               .group = kStorageGroup,
                               .excludes = {"occlusion", "metalness"},
                               .surfaces = kExportJob};
  Parameter smoothness = {.name = "smoothness",
                          .help =
                              "write smoothness = 1 - roughness, which Unity reads: a texture mask instead of orm, "
                              "with metalness in red, occlusion in green, 1 in blue and smoothness in alpha; or, with "
                              "roughness_alone, a texture smoothness",
                          .group = kStorageGroup,
                          .surfaces = kExportJob};
  Parameter write_green = {.name = "write_green",
                           .kind = Kind::kChoice,
                           .help =
                               "green axis of the normals that are written, and of directions of anisotropy: up, as "
                               "OpenGL, glTF, Unity, Godot and Blender have it, or down, as DirectX and Unreal; green "
                               "says how the map is read",
                           .default_text = "up",
                           .choices = choice_names(kGreenAxes),
                           .group = kStorageGroup,
                           .surfaces = kExportJob};
  return {
      {.name = "lobes",
       .help =
           "write the lobes of a baked file, NAME.ndf.exr, as a texture for GPUs, NAME.ktx2, in place of a material "
           "of one lobe; of the options below --texels, --zstd, --device and --report alone go with it",
       .group = kStorageGroup,
       .surfaces = kOnCommandLine},
      {.name = "base_roughness",
       .kind = Kind::kNumber,
       .help = "perceptual roughness of the surface itself, the same everywhere",
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
      surface_parameter("; of levels from 1 on", kExportJob),
      form_parameter("a plane and a sphere, by level the nearest", "one-lobe", kExportJob),
      engine_parameter(kExportJob),
      {.name = "format",
       .kind = Kind::kChoice,
       .help = "files to write: png, an image a level of 8 bits a channel; exr, the same of half floats; ktx2 and "
               "dds (with a DX10 header), a file a texture with all levels",
       .default_text = "by the output's name, else png",
       .choices = choice_names(kMaterialFormats),
       .group = kStorageGroup,
       .surfaces = kExportJob},
      {.name = "texels",
       .kind = Kind::kChoice,
       .help = "how KTX2 and DDS store texels: rgba8; rgba16f, half floats; rg8, as rgba8 but of normals x and y "
               "alone, whose z the shader has to rebuild as sqrt(1 - x^2 - y^2); bc, block-compressed: normals as BC5, "
               "likewise x and y alone, all else as BC7, roughness alone as BC4; lobes as two layers of BC5; uastc, of "
               "KTX2 "
               "only, Basis Universal's format that KHR_texture_basisu has, encoded by Node.js with ktx2-encoder",
       .default_text = "rgba16f of exr, bc of lobes, else rgba8",
       .choices = choice_names(kMaterialTexels),
       .group = kStorageGroup,
       .surfaces = kExportJob},
      {.name = "zstd",
       .kind = Kind::kInteger,
       .help = "supercompress the levels of KTX2 files by Zstandard of this level, without loss; by default "
               "they are not",
       .low = 1,
       .high = 19,
       .group = kStorageGroup,
       .surfaces = kExportJob},
      uastc_effort_parameter(kExportJob),
      encoder_parameter(kOnCommandLine),
      std::move(roughness_alone),
      std::move(smoothness),
      std::move(write_green)};
}

Rows export_run_rows() {
  Rows rows = {
      memory_parameter("memory for buffers and maps; larger maps go by way of a scratch file", 1.0, "256M",
                       kOnCommandLine | kInService),
      device_parameter(kOnCommandLine | kInService),
      {.name = "no_measure",
       .help = "skip measuring the error",
       .excludes = {"optimum", "beside"},
       .surfaces = kOnCommandLine},
      {.name = "optimum",
       .help = "search the least error that any one lobe has, too: seconds a map",
       .excludes = {"no_measure"},
       .surfaces = kOnCommandLine},
      {.name = "beside",
       .kind = Kind::kFile,
       .help = "measure the lobes of this baked file of the same map, too; those of a baked input are anyway",
       .unit = "NAME.ndf.exr",
       .excludes = {"no_measure"},
       .surfaces = kOnCommandLine | kInManifest},
      {.name = "cells",
       .kind = Kind::kInteger,
       .help = "texels of each of levels 2, 4 and 6 whose error is measured",
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
       .help = "write a page with tables, pictures from three distances and moving pictures, beside engines' rules and "
               "baked lobes (made for it unless --beside names some); video by ffmpeg, where it is there",
       .unit = "FILE.html",
       .surfaces = kOnCommandLine},
      {.name = "force",
       .help = "export maps of a manifest again that are unchanged; other exports are always written again",
       .surfaces = kOnCommandLine},
      {.name = "resume",
       .help = "keep what is fitted while it runs, and go on from what a stopped export of the same left",
       .surfaces = kOnCommandLine},
      {.name = "scratch",
       .kind = Kind::kText,
       .help = "folder for data that does not fit in memory",
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
    // A map is read as a bake reads it.
    for (Parameter row : bake_parameters().rows()) {
      if (row.group != kSourceGroup) continue;
      row.surfaces = kExportJob;
      row.hashed_as.clear();
      rows.push_back(std::move(row));
    }
    for (Parameter& row : export_run_rows()) rows.push_back(std::move(row));
    return ParameterTable("export", std::move(rows));
  }();
  return table;
}

}  // namespace multum
