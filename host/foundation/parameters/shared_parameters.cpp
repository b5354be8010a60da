// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/shared_parameters.h"

#include "host/foundation/base/wrap_mode.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

namespace {

constexpr const char kOneLobeGroup[] = "The lobe";

std::vector<std::string> compressions() {
  std::vector<std::string> names = {"none", "rle", "zips", "zip", "piz"};
  for (const char* name : {"zip:", "zips:"})
    for (int level = 1; level <= 9; ++level) names.push_back(name + std::to_string(level));
  return names;
}

}  // namespace

Parameter device_parameter(unsigned surfaces) {
  return {.name = "device",
          .kind = ParameterKind::kText,
          .help = "use this OpenCL device: its number in `multum devices`, or part of its name",
          .surfaces = surfaces};
}

Parameter memory_parameter(const std::string& help, double low, const std::string& default_text, unsigned surfaces) {
  return {.name = "memory",
          .kind = ParameterKind::kBytes,
          .help = help,
          .low = low,
          .high = 1e15,
          .unit = "bytes",
          .default_text = default_text,
          .surfaces = surfaces};
}

Parameter lobe_anisotropy_parameter(unsigned surfaces) {
  return {.name = "anisotropy",
          .help =
              "fit elliptical lobes (KHR_materials_anisotropy), for renderers that align tangents with the mapped "
              "normal",
          .group = kOneLobeGroup,
          .surfaces = surfaces};
}

Parameter fast_lobe_parameter(unsigned surfaces) {
  return {.name = "fast",
          .help = "fit lobes by a closed formula instead of maximum likelihood; the error is a few per cent higher",
          .group = kOneLobeGroup,
          .surfaces = surfaces};
}

Parameter two_channel_parameter(unsigned surfaces) {
  return {.name = "two_channel",
          .help = "read only x and y, and rebuild z",
          .default_text = "detected",
          .hashed_as = "two_channel",
          .excludes = {"z_range"},
          .surfaces = surfaces};
}

Parameter z_range_parameter(unsigned surfaces) {
  return {.name = "z_range",
          .kind = ParameterKind::kChoice,
          .help =
              "set the range of z in the blue channel: -1 to 1, as for x and y (signed), or 0 to 1, as some old tools "
              "write it (positive)",
          .default_text = "detected",
          .choices = choice_names(kZRanges),
          .hashed_as = "z_range",
          .excludes = {"two_channel"},
          .surfaces = surfaces};
}

Parameter surface_parameter(const std::string& more, unsigned surfaces) {
  return {.name = "surface",
          .kind = ParameterKind::kChoice,
          .help =
              "treat each texel as a facet with one normal (texels), or interpolate normals, as renderers do in near "
              "views (interpolated, smoother)" +
              more,
          .default_text = "texels",
          .choices = choice_names(kMapSurfaces),
          .group = kOneLobeGroup,
          .surfaces = surfaces};
}

Parameter form_parameter(const std::string& choice, const std::string& default_text, unsigned surfaces) {
  return {
      .name = "form",
      .kind = ParameterKind::kChoice,
      .help = "write averaged normals with fitted roughness (averages), fitted normals and roughness (one-lobe), or " +
              choice + " (auto)",
      .default_text = default_text,
      .choices = choice_names(kMaterialForms),
      .group = kStorageGroup,
      .surfaces = surfaces};
}

Parameter engine_parameter(const std::string& effect, unsigned surfaces) {
  return {
      .name = "for",
      .kind = ParameterKind::kChoice,
      .help = effect +
              "; --form auto draws its pictures with the texture filter of this engine, and with the roughness that "
              "it adds where normals change between pixels",
      .choices = choice_names(kEngines),
      .group = kStorageGroup,
      .surfaces = surfaces};
}

Parameter uastc_effort_parameter(unsigned surfaces) {
  return {.name = "uastc_effort",
          .kind = ParameterKind::kInteger,
          .help = "set the effort of the UASTC encoder; a higher effort lowers the error but takes longer",
          .low = 0,
          .high = 3,
          .default_text = "1",
          .group = kStorageGroup,
          .surfaces = surfaces};
}

Parameter encoder_parameter(unsigned surfaces) {
  return {.name = "encoder",
          .kind = ParameterKind::kText,
          .help = "encode UASTC with the ktx2-encoder in this folder (the package or a node_modules folder)",
          .unit = "FOLDER",
          .default_text = "where Node.js looks for packages",
          .group = kStorageGroup,
          .surfaces = surfaces};
}

Parameter compression_parameter(unsigned surfaces) {
  return {.name = "compression",
          .kind = ParameterKind::kChoice,
          .help = "compress without loss; zip:1 is the fastest zip level, and zip:9 gives the smallest file",
          .unit = "none|rle|piz|zip[:1-9]|zips[:1-9]",
          .default_text = "zip:1",
          .choices = compressions(),
          .hashed_as = "compression",
          .surfaces = surfaces};
}

Parameter absolute_geometry_parameter() {
  return {.name = "absolute_geometry",
          .help = "store the absolute path of the scene file instead of a path relative to the output",
          .surfaces = kOnCommandLine};
}

Parameter input_parameter(const std::string& name, const std::string& help, unsigned surfaces) {
  return {.name = name, .kind = ParameterKind::kFile, .help = help, .surfaces = surfaces};
}

std::vector<Parameter> wrap_parameters(bool with_auto, const std::string& default_text, unsigned surfaces) {
  std::vector<std::string> modes;
  if (with_auto) modes.emplace_back("auto");
  for (const WrapMode mode : kWrapModes) modes.emplace_back(wrap_mode_name(mode));
  const Parameter both = {.name = "wrap",
                          .kind = ParameterKind::kChoice,
                          .help = std::string("set how the map continues beyond its border") +
                                  (with_auto ? "; auto chooses periodic if the map tiles, and clamp otherwise" : ""),
                          .default_text = default_text,
                          .choices = modes,
                          .hashed_as = "wrap",
                          .surfaces = surfaces};
  Parameter s = both, t = both;
  s.name = "swrap", s.help = "set the wrap mode only along s (x)", s.default_text = "";
  t.name = "twrap", t.help = "set the wrap mode only along t (y)", t.default_text = "";
  return {both, s, t};
}

}  // namespace multum
