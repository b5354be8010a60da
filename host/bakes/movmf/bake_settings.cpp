// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/bake_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <variant>

#include "host/foundation/base/error.h"
#include "host/foundation/parameters/bake_parameters.h"

namespace multum {
namespace {

// Members that are numbers, and their rows of bake_parameters().
struct Field {
  const char* name;
  std::variant<int MovmfSettings::*, float MovmfSettings::*> member;
};
constexpr Field kFields[] = {{"lobes", &MovmfSettings::lobe_count},
                             {"iterations", &MovmfSettings::iteration_count},
                             {"iterations_coarse", &MovmfSettings::iteration_count_coarse},
                             {"iterations_top", &MovmfSettings::iteration_count_top},
                             {"passes", &MovmfSettings::pass_count},
                             {"refit_iterations", &MovmfSettings::refit_iterations},
                             {"convergence_tolerance", &MovmfSettings::convergence_tolerance},
                             {"align", &MovmfSettings::alignment},
                             {"first_level", &MovmfSettings::first_level},
                             {"kappa_cap", &MovmfSettings::kappa_cap},
                             {"kappa_cap_slope", &MovmfSettings::kappa_cap_slope},
                             {"start_kappa_factor", &MovmfSettings::start_kappa_factor},
                             {"start_amplitude_min", &MovmfSettings::start_amplitude_min}};

// A float is held against the bounds as floats: 0.1f is a little above 0.1.
bool is_legal(const Parameter& row, int value) { return multum::is_legal(row, std::int64_t{value}); }
bool is_legal(const Parameter& row, float value) {
  return value >= static_cast<float>(row.low) && value <= static_cast<float>(row.high);
}

}  // namespace

LobeCounts lobe_counts() {
  const Parameter& row = bake_parameters().at("lobes");
  return {static_cast<int>(row.low), static_cast<int>(row.high)};
}

void make_reference(MovmfSettings& settings) {
  settings.coarse_normals = CoarseNormals::kAll;
  settings.convergence_tolerance = 0.0f;
  settings.iteration_count = settings.iteration_count_coarse = 30;
  settings.refit_iterations = 10;
}

void make_unaligned(MovmfSettings& settings) {
  settings.aligned_start = false;
  settings.alignment = 0.0f;
  settings.pass_count = 1;
}

void validate(const MovmfSettings& settings) {
  for (const Field& field : kFields)
    std::visit(
        [&](auto member) {
          const Parameter& row = bake_parameters().at(field.name);
          const auto value = settings.*member;
          if (!is_legal(row, value))
            throw Error(ErrorCode::kUsage,
                        fmt::format("{} is {}, expected {}", row.surfaces == 0 ? row.name : row.option(), value,
                                    expected_text(row)));
        },
        field.member);
  const RepresentationInfo& lobes = representation_info(settings.representation);
  if (settings.refine && !lobes.has_kappa)
    throw Error(ErrorCode::kUsage, fmt::format("--refine is given with --ndf {}, expected --ndf vmf: it knows no {}",
                                               lobes.option, lobes.contents));
  if (settings.refine && settings.coarse_normals == CoarseNormals::kAll)
    throw Error(ErrorCode::kUsage,
                "--refine is given with --coarse-normals all (which --reference sets), expected binned normals");
}

std::string settings_json(const MovmfSettings& s) {
  nlohmann::json json;  // an object: keys are sorted
  json["representation"] = representation_info(s.representation).name;
  for (const Field& field : kFields)
    std::visit([&](auto member) { json[bake_parameters().at(field.name).hashed_as] = s.*member; }, field.member);
  json["coarse_normals"] = s.coarse_normals == CoarseNormals::kBinned ? "condensed" : "all";
  json["order"] = s.order == FitOrder::kColour ? "colour" : "scanline";
  json["rehearse_start"] = s.search_start;
  json["periodic"] = {s.periodic_x, s.periodic_y};
  json["aligned_start"] = s.aligned_start;
  // Absent otherwise: files from before them keep their hash.
  if (s.refine) json["refined"] = true;
  if (s.farthest_start) json["farthest_start"] = true;
  return json.dump();
}

}  // namespace multum
