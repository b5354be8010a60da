// SPDX-License-Identifier: Apache-2.0
#include "host/parameters/pack_parameters.h"

#include "host/parameters/shared_parameters.h"

namespace multum {
namespace {

constexpr unsigned kPackJob = kOnCommandLine | kInService;

/// Of these at most one is given.
std::vector<Parameter> target_parameters() {
  std::vector<Parameter> rows = {
      {.name = "ratio",
       .kind = ParameterKind::kNumber,
       .help = "bytes of raw 24-bit frames over the file's, at least; 384 without a target",
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
    rows.push_back(absolute_geometry_parameter());
    return ParameterTable("pack", std::move(rows));
  }();
  return table;
}

}  // namespace multum
