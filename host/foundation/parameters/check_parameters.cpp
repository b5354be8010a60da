// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/check_parameters.h"

#include <utility>

#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;

std::vector<Parameter> check_rows() {
  Parameter engine = engine_parameter("", kOnCommandLine);
  engine.help = "draw the pictures as this engine does";
  std::vector<Parameter> rows = {{.name = "tile_size",
                                  .kind = Kind::kNumber,
                                  .help = "set the size of the map on the surface; models have their own",
                                  .low = 0.0,
                                  .high = 1e6,
                                  .low_excluded = true,
                                  .unit = "metres",
                                  .default_text = "1",
                                  .surfaces = kOnCommandLine},
                                 {.name = "base_roughness",
                                  .kind = Kind::kNumber,
                                  .help = "set the perceptual roughness; models have their own",
                                  .low = 0.0,
                                  .high = 1.0,
                                  .default_text = "0.3",
                                  .surfaces = kOnCommandLine},
                                 {.name = "metal", .help = "measure the map on a metal", .surfaces = kOnCommandLine},
                                 std::move(engine),
                                 {.name = "fail_below",
                                  .kind = Kind::kNumber,
                                  .help = "exit with code 5 if a map gains fewer percentage points from every distance",
                                  .low = 0.0,
                                  .high = 100.0,
                                  .unit = "points",
                                  .surfaces = kOnCommandLine},
                                 device_parameter(kOnCommandLine)};
  for (Parameter& row : rows) row.group = "Measuring the gain";
  return rows;
}

}  // namespace

const ParameterTable& check_parameters() {
  static const ParameterTable table = [] {
    std::vector<Parameter> rows = check_rows();
    for (Parameter& row : reading_parameters(kOnCommandLine)) rows.push_back(std::move(row));
    return ParameterTable("check", std::move(rows));
  }();
  return table;
}

}  // namespace multum
