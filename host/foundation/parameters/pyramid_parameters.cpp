// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/pyramid_parameters.h"

#include <utility>

#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;
using Rows = std::vector<Parameter>;

Parameter data_format_parameter(const char* default_text) {
  return {.name = "data_format",
          .kind = Kind::kChoice,
          .help = "set the storage precision",
          .default_text = default_text,
          .choices = {choice_name(kStorageEncodings, StorageEncoding::kHalf),
                      choice_name(kStorageEncodings, StorageEncoding::kFloat)},
          .short_option = "-d",
          .surfaces = kOnCommandLine};
}

// A colour, a direction or another list of numbers that is written as one string.
Parameter numbers_parameter(const char* name, const char* help, const char* unit, const char* default_text) {
  return {.name = name,
          .kind = Kind::kText,
          .help = help,
          .unit = unit,
          .default_text = default_text,
          .surfaces = kOnCommandLine};
}

// Adds the rows that are at the end of all three tables.
ParameterTable table_of(const char* command, Rows rows) {
  rows.push_back(
      memory_parameter("use at most this much memory for buffers and the image; larger images use a scratch"
                       " file",
                       1.0, "256M", kOnCommandLine));
  rows.push_back(device_parameter(kOnCommandLine));
  Parameter compression = compression_parameter(kOnCommandLine);
  compression.hashed_as.clear();
  rows.push_back(std::move(compression));
  rows.push_back({.name = "report",
                  .kind = Kind::kText,
                  .help = "write times, counts and the content hash as JSON",
                  .unit = "FILE",
                  .surfaces = kOnCommandLine});
  rows.push_back({.name = "force",
                  .help = "write again even if the source and the settings have not changed",
                  .surfaces = kOnCommandLine});
  return {command, std::move(rows)};
}

void add_wraps(Rows& rows, const char* default_text) {
  for (Parameter& row : wrap_parameters(false, default_text, kOnCommandLine)) {
    row.hashed_as.clear();
    rows.push_back(std::move(row));
  }
}

}  // namespace

const ParameterTable& mip_parameters() {
  static const ParameterTable table = [] {
    Rows rows = {{.name = "colours",
                  .kind = Kind::kChoice,
                  .help = "set the meaning of the values: srgb, linear or data (not colours; values may be negative); "
                          "auto reads floats as linear, and integers as sRGB unless the file states otherwise",
                  .default_text = "auto",
                  .choices = choice_names(kColourEncodings),
                  .surfaces = kOnCommandLine},
                 data_format_parameter("half")};
    add_wraps(rows, "periodic");
    return table_of("mip", std::move(rows));
  }();
  return table;
}

const ParameterTable& lod_parameters() {
  static const ParameterTable table = [] {
    Rows rows = {{.name = "of",
                  .kind = Kind::kChoice,
                  .help = "read heights (from the first channel) or positions (from three channels)",
                  .default_text = "heights",
                  .choices = {"heights", "positions"},
                  .surfaces = kOnCommandLine},
                 {.name = "scale",
                  .kind = Kind::kNumber,
                  .help = "multiply all numbers by this",
                  .low = -kUnbounded,
                  .high = kUnbounded,
                  .zero_excluded = true,
                  .default_text = "1",
                  .surfaces = kOnCommandLine},
                 data_format_parameter("float")};
    add_wraps(rows, "clamp");
    return table_of("lod", std::move(rows));
  }();
  return table;
}

const ParameterTable& reflectance_parameters() {
  static const ParameterTable table = table_of(
      "reflectance",
      {{.name = "light",
        .kind = Kind::kText,
        .help = "add a distant light: the direction towards the light, then optionally its irradiance, a grey value or"
                " red, green, blue",
        .unit = "X,Y,Z[,Y|,R,G,B]",
        .is_repeatable = true,
        .surfaces = kOnCommandLine},
       {.name = "environment",
        .kind = Kind::kFile,
        .help = "light the surface with this latitude-longitude image, with +Y at the top and -Z in the "
                "middle",
        .surfaces = kOnCommandLine},
       {.name = "environment_scale",
        .kind = Kind::kNumber,
        .help = "multiply the radiance of the environment by this",
        .low = 0.0,
        .high = kUnbounded,
        .default_text = "1",
        .surfaces = kOnCommandLine},
       numbers_parameter("viewer", "set the direction towards the distant viewer", "X,Y,Z", "0,0,1"),
       numbers_parameter("up", "set the up direction of the map", "X,Y,Z", "0,1,0"),
       {.name = "brdf",
        .kind = Kind::kBrdf,
        .help = "set the BRDF of the surface: blinn-phong:S with S from 1 to 100000",
        .default_text = "blinn-phong:100",
        .surfaces = kOnCommandLine},
       numbers_parameter("diffuse", "set the diffuse reflectance: a grey value, or red, green, blue", "Y|R,G,B", "0.5"),
       numbers_parameter("specular", "set the specular factor: a grey value, or red, green, blue", "Y|R,G,B", "0.1"),
       {.name = "size",
        .kind = Kind::kInteger,
        .help = "set the width and height of the map in texels",
        .low = 4,
        .high = 8192,
        .unit = "texels",
        .default_text = "512",
        .surfaces = kOnCommandLine},
       {.name = "texel_samples",
        .kind = Kind::kInteger,
        .help = "average this many normals along each side of a texel",
        .low = 1,
        .high = 16,
        .default_text = "2",
        .surfaces = kOnCommandLine},
       data_format_parameter("half")});
  return table;
}

}  // namespace multum
