// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/pack_parameters.h"

#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

constexpr unsigned kPackJob = kOnCommandLine | kInService;
constexpr double kLeastPackMemory = 256.0 * 1024 * 1024;

/// At most one of these parameters may be given.
std::vector<Parameter> target_parameters() {
  std::vector<Parameter> rows = {
      {.name = "ratio",
       .kind = ParameterKind::kNumber,
       .help = "make the file at least this many times smaller than uncompressed 24-bit frames (default: 384, or less "
               "if a ratio of 384 would add an error of more than 3 times the error of the inferred textures)",
       .low = 1,
       .high = 1e6,
       .surfaces = kPackJob},
      {.name = "bytes",
       .kind = ParameterKind::kBytes,
       .help = "write at most this many bytes",
       .low = 1,
       .high = 1e15,
       .unit = "bytes",
       .surfaces = kPackJob},
      {.name = "mse_max",
       .kind = ParameterKind::kNumber,
       .help = "add at most this estimated mean squared error to drawn frames, in 8-bit units at gamma 2.2",
       .low = 1e-3,
       .high = 65025,
       .surfaces = kPackJob},
      {.name = "lambda",
       .kind = ParameterKind::kNumber,
       .help = "set lambda, the increase in squared error that is accepted in exchange for saving one bit",
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
    std::vector<Parameter> rows = {input_parameter("manifest", "inferred.json of `multum infer`", kInService)};
    for (Parameter& row : target_parameters()) rows.push_back(std::move(row));
    rows.push_back({.name = "block",
                    .kind = ParameterKind::kInteger,
                    .help = "put at most this many samples along each parameter into a chunk",
                    .low = 1,
                    .high = 64,
                    .default_text = "8",
                    .surfaces = kPackJob});
    rows.push_back({.name = "stagger",
                    .kind = ParameterKind::kChoice,
                    .help = "start the chunks of different objects at different samples, so that a path needs fewer "
                            "new chunks at once; the field must have more samples than --block",
                    .default_text = "no",
                    .choices = {"no", "yes"},
                    .surfaces = kPackJob});
    rows.push_back({.name = "alpha",
                    .kind = ParameterKind::kNumber,
                    .help = "limit the mean error of an object to this many times the mean error over all "
                            "objects: a number above 1, or 0 for no limit",
                    .low = 0,
                    .high = 1e6,
                    .default_text = "0",
                    .surfaces = kPackJob});
    rows.push_back({.name = "pyramid",
                    .kind = ParameterKind::kChoice,
                    .help = "set how chunks are coded: by the best of several pyramids and learnt bases (adaptive), by"
                            " the search of the paper (greedy), by levels of 1, 2, 4 ... samples (plain), or sample by"
                            " sample (none)",
                    .default_text = "adaptive",
                    .choices = choice_names(kPyramidChoices),
                    .surfaces = kPackJob});
    rows.push_back({.name = "coder",
                    .kind = ParameterKind::kChoice,
                    .help = "code images by block cosines (dct), embedded wavelets (wavelet), or the better method for"
                            " each chunk (auto)",
                    .default_text = "auto",
                    .choices = {"auto", "dct", "wavelet"},
                    .surfaces = kPackJob});
    rows.push_back({.name = "loop",
                    .kind = ParameterKind::kChoice,
                    .help = "let finer images correct the coding errors of coarser images (closed), or do not correct "
                            "these errors, as in the paper (open)",
                    .default_text = "closed",
                    .choices = {"closed", "open"},
                    .surfaces = kPackJob});
    rows.push_back(
        memory_parameter("limit the resident memory to this size; less memory makes packing slower, with the same "
                         "result",
                         kLeastPackMemory, "a quarter of the memory of the machine", kPackJob));
    rows.push_back(
        {.name = "resume", .help = "continue an interrupted packing to the same output", .surfaces = kOnCommandLine});
    rows.push_back(absolute_geometry_parameter());
    return ParameterTable("pack", std::move(rows));
  }();
  return table;
}

}  // namespace multum
