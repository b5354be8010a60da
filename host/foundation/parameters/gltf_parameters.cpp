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
           .help = "store new textures as uastc (KHR_texture_basisu), rgba8 (KTX2, which this extension does not "
                   "allow), png (only level 0) or the best format for each texture (auto)",
           .default_text = "auto",
           .choices = choice_names(kGltfTextureFormats),
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          {.name = "png_fallback",
           .help = "also store level 0 of each new texture as a plain image, so that loaders need no "
                   "KHR_texture_basisu",
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          form_parameter(
              "the cheapest textures, new or old, whose error in pictures is within 0.2 points of the lowest error",
              "auto", kOnCommandLine),
          engine_parameter("write images that this engine loads: sets --format, unless it is given", kOnCommandLine),
          uastc_effort_parameter(kOnCommandLine),
          encoder_parameter(kOnCommandLine),
          {.name = "lobes",
           .help = "add lobes where they are more accurate, in the extension MULTUM_lobes for @multum/three; "
                   "other viewers draw the textures",
           .group = kStorageGroup,
           .excludes = {"anisotropy"},
           .surfaces = kOnCommandLine},
          {.name = "lobe_texels",
           .kind = Kind::kChoice,
           .help = "set the texel format of lobes: bc (BC5 blocks), rgba8 (twice the bytes of bc) or rgba16f (four "
                   "times the bytes of bc); only with --lobes",
           .default_text = "rgba8 with --format rgba8, else bc if it adds less than 0.3 points of error",
           .choices = choice_names(kLobeTexels),
           .group = kStorageGroup,
           .surfaces = kOnCommandLine},
          std::move(two_channel),
          std::move(z_range),
          std::move(anisotropy),
          fast_lobe_parameter(kOnCommandLine),
          surface_parameter("; level 0 does not change", kOnCommandLine)};
}

std::vector<Parameter> gltf_run_rows() {
  std::vector<Parameter> rows = {
      memory_parameter("use at most this much memory for buffers and maps; larger maps use a scratch file", 1.0, "256M",
                       kOnCommandLine),
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
