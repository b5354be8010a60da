// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/bake_settings.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <variant>

#include "host/foundation/base/error.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {
namespace {

// The numeric members and their rows in bake_parameters().
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

// The Boolean members, and the value to which each option sets its member.
struct Flag {
  const char* name;
  bool MovmfSettings::*member;
  bool value;
};
constexpr Flag kFlags[] = {{"refine", &MovmfSettings::refine, true},
                           {"no_start_search", &MovmfSettings::search_start, false},
                           {"farthest_start", &MovmfSettings::farthest_start, true}};

// Returns the key in multum:settings.
const std::string& hashed_as(const char* name) { return bake_parameters().at(name).hashed_as; }

// Compares a float with the bounds as floats, because 0.1f is slightly above 0.1.
bool is_legal(const Parameter& row, int value) { return multum::is_legal(row, std::int64_t{value}); }
bool is_legal(const Parameter& row, float value) {
  return value >= static_cast<float>(row.low) && value <= static_cast<float>(row.high);
}

void take(const ParameterValues& values, const char* name, int& value) { value = values.integer(name).value_or(value); }
void take(const ParameterValues& values, const char* name, float& value) {
  if (const auto number = values.number(name)) value = static_cast<float>(*number);
}

}  // namespace

void apply(const ParameterValues& values, MovmfSettings& settings) {
  // Applies presets first, so that other given values override the presets.
  if (values.flag("reference")) make_reference(settings);
  if (values.flag("unaligned")) make_unaligned(settings);
  for (const Field& field : kFields)
    std::visit([&](auto member) { take(values, field.name, settings.*member); }, field.member);
  if (values.has("iterations")) settings.iteration_count_coarse = settings.iteration_count;
  for (const Flag& flag : kFlags)
    if (values.flag(flag.name)) settings.*flag.member = flag.value;
  settings.order = values.choice("order", kFitOrders).value_or(settings.order);
  settings.coarse_normals = values.choice("coarse_normals", kCoarseNormals).value_or(settings.coarse_normals);
}

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
    throw Error(ErrorCode::kUsage,
                fmt::format("--refine is given with --ndf {}, expected --ndf vmf, because --refine does not support {}",
                            lobes.option, lobes.contents));
  if (settings.refine && settings.coarse_normals == CoarseNormals::kAll)
    throw Error(ErrorCode::kUsage,
                "--refine is given with --coarse-normals all (which --reference sets), expected binned normals");
}

std::string settings_json(const MovmfSettings& s) {
  nlohmann::json json;  // an object with sorted keys
  json[hashed_as("ndf")] = representation_info(s.representation).name;
  for (const Field& field : kFields)
    std::visit([&](auto member) { json[hashed_as(field.name)] = s.*member; }, field.member);
  json[hashed_as("coarse_normals")] = choice_name(kHashedCoarseNormals, s.coarse_normals);
  json[hashed_as("order")] = choice_name(kFitOrders, s.order);
  json[hashed_as("no_start_search")] = s.search_start;
  json["periodic"] = {s.periodic_x, s.periodic_y};
  json[hashed_as("unaligned")] = s.aligned_start;
  // Adds these settings only if they are true, so that the hash of files from earlier program versions does not change.
  if (s.refine) json[hashed_as("refine")] = true;
  if (s.farthest_start) json[hashed_as("farthest_start")] = true;
  return json.dump();
}

}  // namespace multum
