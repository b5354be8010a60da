// SPDX-License-Identifier: Apache-2.0
#include "host/bake/bake_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/error.h"

namespace multum {
namespace {

template <typename Value>
void check_range(const char* name, Value value, SettingRange<Value> range) {
  if (!(value >= range.low && value <= range.high))
    throw Error(ErrorCode::kUsage, fmt::format("{} is {}, expected {} to {}", name, value, range.low, range.high));
}

}  // namespace

void make_reference(MovmfSettings& settings) {
  settings.coarse_normals = CoarseNormals::kAll;
  settings.settled_change = 0.0f;
  settings.iteration_count = settings.iteration_count_coarse = 30;
  settings.iteration_count_again = 10;
}

void validate(const MovmfSettings& s) {
  check_range("--lobes", s.lobe_count, kLobeCounts);
  check_range("--iterations", s.iteration_count, kIterationCounts);
  check_range("the iteration count of coarse levels", s.iteration_count_coarse, kIterationCounts);
  check_range("the iteration count of the coarsest level", s.iteration_count_top, kIterationCounts);
  check_range("--sweeps", s.sweep_count, kSweepCounts);
  check_range("the iteration count of further sweeps", s.iteration_count_again, kIterationCounts);
  check_range("the change at which texels are settled", s.settled_change, {0.0f, 0.1f});
  check_range("--align", s.alignment, kAlignments);
  check_range("--first-level", s.first_level, kFirstLevels);
  check_range("--kappa-cap", s.kappa_cap, kKappaCaps);
  check_range("the slope of the kappa cap", s.kappa_cap_slope, {0.0f, 1000.0f});
  check_range("the kappa factor of starts", s.start_kappa_factor, {0.01f, 1.0f});
  check_range("the least amplitude of starts", s.start_amplitude_min, {0.0f, 0.125f});
}

std::string settings_json(const MovmfSettings& s) {
  nlohmann::json json;  // an object: keys are sorted
  json["representation"] = representation_info(s.representation).name;
  json["lobes"] = s.lobe_count;
  json["iterations"] = s.iteration_count;
  json["iterations_coarse"] = s.iteration_count_coarse;
  json["iterations_top"] = s.iteration_count_top;
  json["sweeps"] = s.sweep_count;
  json["iterations_again"] = s.iteration_count_again;
  json["settled_change"] = s.settled_change;
  json["coarse_normals"] = s.coarse_normals == CoarseNormals::kCondensed ? "condensed" : "all";
  json["order"] = s.order == FitOrder::kColour ? "colour" : "scanline";
  json["align"] = s.alignment;
  json["rehearse_start"] = s.rehearse_start;
  json["periodic"] = {s.periodic_x, s.periodic_y};
  json["aligned_start"] = s.aligned_start;
  json["first_level"] = s.first_level;
  json["kappa_cap"] = s.kappa_cap;
  json["kappa_cap_slope"] = s.kappa_cap_slope;
  json["start_kappa_factor"] = s.start_kappa_factor;
  json["start_amplitude_min"] = s.start_amplitude_min;
  return json.dump();
}

}  // namespace multum
