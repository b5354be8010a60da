// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/infer_parameters.h"

#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;

constexpr unsigned kPlaces = kOnCommandLine | kInService;

}  // namespace

const ParameterTable& infer_parameters() {
  static const ParameterTable table(
      "infer",
      {input_parameter("job", "animation.toml of `multum animation`", kInService),
       {.name = "hold_out",
        .kind = Kind::kInteger,
        .help = "exclude every Nth view from the fit of view-independent layers, and report the errors of "
                "these views",
        .low = 2,
        .high = 1000,
        .surfaces = kPlaces},
       {.name = "tolerance",
        .kind = Kind::kNumber,
        .help = "stop the fit of a texture when its relative gradient is at most this",
        .low = 1e-7,
        .high = 1,
        .default_text = "0.001",
        .surfaces = kPlaces},
       {.name = "iterations",
        .kind = Kind::kInteger,
        .help = "run at most this many iterations of conjugate gradients per texture",
        .low = 1,
        .high = 100000,
        .default_text = "400",
        .surfaces = kPlaces},
       {.name = "no_frames", .help = "do not draw the frames that the report measures and shows", .surfaces = kPlaces},
       {.name = "no_comparison",
        .help = "do not compare samplers, regularisation and forward mapping",
        .surfaces = kPlaces},
       {.name = "report_sample",
        .kind = Kind::kText,
        .help = "show the sample with these indices along the parameters, or with this name, in the report",
        .default_text = "the middle sample",
        .surfaces = kPlaces},
       {.name = "context",
        .kind = Kind::kChoice,
        .help = "use this OpenGL implementation for drawing: auto, osmesa (software) or egl",
        .default_text = "auto",
        .choices = choice_names(kContextBackends),
        .surfaces = kPlaces},
       {.name = "force", .help = "infer textures again even if they exist", .surfaces = kOnCommandLine},
       absolute_geometry_parameter(),
       device_parameter(kPlaces)});
  return table;
}

}  // namespace multum
