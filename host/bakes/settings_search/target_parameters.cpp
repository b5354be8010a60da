// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/target_parameters.h"

#include <fmt/format.h>

#include "host/bakes/bake/job_parameters.h"
#include "host/foundation/base/error.h"

namespace multum {

bool has_target(const ParameterValues& values) { return values.has("target_error") || values.has("budget_ms"); }

BakeTarget bake_target(const ParameterValues& values, const std::string& viewer) {
  BakeTarget target;
  target.error = values.number("target_error");
  if (const auto budget = values.number("budget_ms")) target.seconds = *budget / 1e3;
  target.brdf = parse_target_brdf(values.text("brdf").value_or(TargetBrdf().text));
  target.only = given_representation(values);
  target.best_effort = values.flag("best_effort");
  if (target.error) target.viewer.program = viewer;
  return target;
}

void check_target_values(const ParameterValues& values) {
  if (!has_target(values)) {
    if (values.has("brdf") || values.flag("best_effort"))
      throw Error(ErrorCode::kUsage, "--brdf and --best-effort need --target-error or --budget-ms, found neither");
    return;
  }
  if (const Parameter* chosen = given_of_target(values))
    throw Error(ErrorCode::kUsage,
                fmt::format("{} and {} are mutually exclusive, because a target chooses that setting", chosen->option(),
                            values.has("target_error") ? "--target-error" : "--budget-ms"));
}

void check_met(const BakeJob& job, const ChosenBake& chosen) {
  if (chosen.met) return;
  throw Error(ErrorCode::kVerification,
              chosen.written ? job.input + ": no settings reach the target, so the best settings were used"
                             : fmt::format("{}: no settings reach the target: {}--best-effort writes the best result",
                                           job.input, chosen.report.choice));
}

}  // namespace multum
