// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/gltf_parameters.h"

#include <utility>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;

std::vector<Parameter> gltf_rows() {
  Parameter two_channel = two_channel_parameter(kOnCommandLine), z_range = z_range_parameter(kOnCommandLine);
  two_channel.group = z_range.group = kSourceGroup;
  Parameter anisotropy = lobe_anisotropy_parameter(kOnCommandLine);
  anisotropy.excludes = {"lobes"};
  return {{.name = "format",
           .kind = Kind::kChoice,
           .help = "images of the new textures: uastc, of KHR_texture_basisu, encoded by Node.js with ktx2-encoder; "
                   "rgba8, KTX2 of 8 bits a channel, outside of that extension; png, level 0 alone; auto, uastc for "
                   "each texture where that adds less than 0.3 % to the light's error, else rgba8 and a fallback",
           .default_text = "auto",
           .choices = choice_names(kGltfTextureFormats),
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          {.name = "png_fallback",
           .help = "store level 0 of each new texture as a plain image too, for loaders without KHR_texture_basisu, "
                   "which is not required then",
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          form_parameter("the model, the cheapest form that is within 0.2 points of the least error, which may be the "
                         "textures that there are",
                         "auto", kOnCommandLine),
          engine_parameter(kOnCommandLine),
          uastc_effort_parameter(kOnCommandLine),
          encoder_parameter(kOnCommandLine),
          {.name = "lobes",
           .help = "put lobes of normals, where they are nearer, into the extension MULTUM_lobes, which @multum/three "
                   "draws; other viewers draw the textures. With another form than auto: into all materials",
           .group = kStorageGroup,
           .excludes = {"anisotropy"},
           .surfaces = kOnCommandLine},
          {.name = "lobe_texels",
           .kind = Kind::kChoice,
           .help = "texels of lobes: bc, blocks of BC5, a quarter of the bytes of halfs; rgba8, half of them; rgba16f, "
                   "half floats; only with --lobes",
           .default_text = "rgba8 with --format rgba8, else bc where it adds less than 0.3 points",
           .choices = choice_names(kLobeTexels),
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          std::move(two_channel),
          std::move(z_range),
          std::move(anisotropy),
          fast_lobe_parameter(kOnCommandLine),
          surface_parameter("; of levels from 1 on", kOnCommandLine)};
}

std::vector<Parameter> gltf_run_rows() {
  std::vector<Parameter> rows = {
      memory_parameter("memory for buffers and maps; larger maps go by way of a scratch file beside the output", 1.0,
                       "256M", kOnCommandLine),
      device_parameter(kOnCommandLine),
      {.name = "report",
       .kind = Kind::kText,
       .help = "write materials, textures, sizes and times as JSON",
       .unit = "FILE",
       .surfaces = kOnCommandLine}};
  for (Parameter& row : rows) row.group = "Running the conversion";
  return rows;
}

}  // namespace

const ParameterTable& gltf_parameters() {
  static const ParameterTable table = [] {
    std::vector<Parameter> rows = gltf_rows();
    for (Parameter& row : gltf_run_rows()) rows.push_back(std::move(row));
    return ParameterTable("gltf", std::move(rows));
  }();
  return table;
}

}  // namespace multum
