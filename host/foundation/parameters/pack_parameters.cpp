// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/pack_parameters.h"

#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

constexpr unsigned kPackJob = kOnCommandLine | kInService;
constexpr double kLeastPackMemory = 256.0 * 1024 * 1024;

/// Of these at most one is given.
std::vector<Parameter> target_parameters() {
  std::vector<Parameter> rows = {
      {.name = "ratio",
       .kind = ParameterKind::kNumber,
       .help = "bytes of raw 24-bit frames over the file's, at least; 384 without a target, or less where that would "
               "add more than 3 times the error of the inferred textures",
       .low = 1,
       .high = 1e6,
       .surfaces = kPackJob},
      {.name = "bytes",
       .kind = ParameterKind::kBytes,
       .help = "bytes of the file, at most",
       .low = 1,
       .high = 1e15,
       .unit = "bytes",
       .surfaces = kPackJob},
      {.name = "mse_max",
       .kind = ParameterKind::kNumber,
       .help = "mean squared error that coding may add to drawn frames, as estimated, in 8-bit units at gamma 2.2",
       .low = 1e-3,
       .high = 65025,
       .surfaces = kPackJob},
      {.name = "lambda",
       .kind = ParameterKind::kNumber,
       .help = "squared error that a bit is worth",
       .low = 1e-4,
       .high = 1e9,
       .surfaces = kPackJob}};
  for (Parameter& row : rows)
    for (const Parameter& other : rows)
      if (other.name != row.name) row.excludes.push_back(other.name);
  return rows;
}

}  // namespace

const ParameterTable& pack_parameters() {
  static const ParameterTable table = [] {
    std::vector<Parameter> rows = {
        input_parameter("manifest", "inferred.json, as `multum infer` writes it", kInService)};
    for (Parameter& row : target_parameters()) rows.push_back(std::move(row));
    rows.push_back({.name = "block",
                    .kind = ParameterKind::kInteger,
                    .help = "samples of a chunk along a parameter, at most",
                    .low = 1,
                    .high = 64,
                    .default_text = "8",
                    .surfaces = kPackJob});
    rows.push_back({.name = "stagger",
                    .kind = ParameterKind::kChoice,
                    .help = "begin the chunks of different objects at different samples, where there are more than "
                            "`block` along a parameter: a path meets fewer new chunks at once",
                    .default_text = "no",
                    .choices = {"no", "yes"},
                    .surfaces = kPackJob});
    rows.push_back({.name = "alpha",
                    .kind = ParameterKind::kNumber,
                    .help = "an object's mean error over that of all objects' pixels, at most; above 1, or 0: any",
                    .low = 0,
                    .high = 1e6,
                    .default_text = "0",
                    .surfaces = kPackJob});
    rows.push_back({.name = "pyramid",
                    .kind = ParameterKind::kChoice,
                    .help =
                        "images of a chunk: the best of a few pyramids over the parameters and of learnt bases, the "
                        "paper's greedy search, 1, 2, 4 ... samples along all parameters, or every sample by itself",
                    .default_text = "adaptive",
                    .choices = choice_names(kPyramidChoices),
                    .surfaces = kPackJob});
    rows.push_back({.name = "coder",
                    .kind = ParameterKind::kChoice,
                    .help = "coder of images: block cosines, embedded wavelets, or of each chunk the better one",
                    .default_text = "auto",
                    .choices = {"auto", "dct", "wavelet"},
                    .surfaces = kPackJob});
    rows.push_back({.name = "loop",
                    .kind = ParameterKind::kChoice,
                    .help = "finer images correct what coding has done to coarser ones (closed), or not, as in the "
                            "paper (open)",
                    .default_text = "closed",
                    .choices = {"closed", "open"},
                    .surfaces = kPackJob});
    rows.push_back(
        memory_parameter("resident memory to stay within: fewer chunks are coded at once, and textures read "
                         "again, with the same result",
                         kLeastPackMemory, "a quarter of the machine's", kPackJob));
    rows.push_back({.name = "resume",
                    .help = "take up what a packing to the same output has coded before it was stopped",
                    .surfaces = kOnCommandLine});
    rows.push_back(absolute_geometry_parameter());
    return ParameterTable("pack", std::move(rows));
  }();
  return table;
}

}  // namespace multum
