// SPDX-License-Identifier: Apache-2.0
// Reads the target of a bake from the parameters of `multum bake`, for the command line and for libmultum.
#pragma once

#include "host/bakes/settings_search/chosen_bake.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Returns whether a target error or a time budget is given, so that settings must be chosen.
bool has_target(const ParameterValues& values);

/// Returns the target. `viewer` is the program that draws a picture of the result (BakeTarget::viewer).
BakeTarget bake_target(const ParameterValues& values, const std::string& viewer);

/// Throws Error(kUsage) if there are target parameters without a target, or settings that would be chosen for the
/// target.
void check_target_values(const ParameterValues& values);

/// Throws Error(kVerification) if no settings reach the target.
void check_met(const BakeJob& job, const ChosenBake& chosen);

}  // namespace multum
