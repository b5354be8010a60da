// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/infer_parameters.h"

#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {

const ParameterTable& infer_parameters() {
  using Kind = ParameterKind;
  constexpr unsigned kJob = kOnCommandLine | kInService;
  static const ParameterTable table(
      "infer", {input_parameter("job", "animation.toml of `multum animation`", kInService),
                {.name = "hold_out",
                 .kind = Kind::kInteger,
                 .help = "leave every Nth view out of view-independent layers, and report the error at those views",
                 .low = 2,
                 .high = 1000,
                 .surfaces = kJob},
                {.name = "tolerance",
                 .kind = Kind::kNumber,
                 .help = "stop when the relative gradient of a texture is at most this",
                 .low = 1e-7,
                 .high = 1,
                 .default_text = "0.001",
                 .surfaces = kJob},
                {.name = "iterations",
                 .kind = Kind::kInteger,
                 .help = "run at most this many iterations of conjugate gradients per texture",
                 .low = 1,
                 .high = 100000,
                 .default_text = "400",
                 .surfaces = kJob},
                {.name = "no_frames", .help = "skip the frames that the report measures and shows", .surfaces = kJob},
                {.name = "no_comparison",
                 .help = "skip comparing samplers, regularisation and forward mapping at --report-sample",
                 .surfaces = kJob},
                {.name = "report_sample",
                 .kind = Kind::kText,
                 .help = "show this sample in the report: its index along each parameter, or its name",
                 .default_text = "the middle sample",
                 .surfaces = kJob},
                {.name = "context",
                 .kind = Kind::kChoice,
                 .help = "use this OpenGL implementation for drawing: auto, osmesa (software) or egl",
                 .default_text = "auto",
                 .choices = choice_names(kContextBackends),
                 .surfaces = kJob},
                {.name = "force", .help = "infer existing textures again", .surfaces = kOnCommandLine},
                absolute_geometry_parameter(),
                device_parameter(kJob)});
  return table;
}

}  // namespace multum
