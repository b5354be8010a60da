// SPDX-License-Identifier: Apache-2.0
// Applies the parameters of bake_parameters() to a job: the same words make the same job, on command lines, in
// manifests, scenes and candidates of a target.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>

#include "host/bakes/bake/bake_job.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Of bake_parameters(): bake_values({{"ndf", "vmf"}, {"lobes", 3}}).
ParameterValues bake_values(std::initializer_list<std::pair<const char*, ParameterValue>> values = {});

/// What was given replaces what the job has; the storage encoding becomes that of the representation where none was
/// given.
void apply(const ParameterValues& values, BakeJob& job);

/// The representation of `ndf`; unset where it was not given.
std::optional<Representation> given_representation(const ParameterValues& values);

/// The given parameter that a target chooses; null: there is none.
const Parameter* given_of_target(const ParameterValues& values);
/// Without any.
ParameterValues without_those_of_target(ParameterValues values);

/// What they say of the representation, the fit and the storage, as `multum bake` takes it: "--ndf vmf --lobes 3".
std::string options_text(const ParameterValues& values);

/// A parameter of `table` for another representation than `ndf`; null: there is none. Of `values`, where it is given.
const Parameter* given_of_another_ndf(const ParameterValues& values);
/// "for vmf and gmm": the values of --ndf that the parameter is for.
std::string scope_text(const Parameter& parameter);
/// Throws Error(kUsage) for a parameter of another representation: "--lobes is for --ndf vmf and gmm, found --ndf sh".
void check_scopes(const ParameterValues& values);

}  // namespace multum
