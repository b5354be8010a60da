// SPDX-License-Identifier: Apache-2.0
// Applies the parameters of bake_parameters() to a job. Equal parameters therefore make equal jobs, whether they come
// from a command line, a manifest, a scene or the candidates of a target.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>

#include "host/bakes/bake/bake_job.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Makes values of bake_parameters(), as in bake_values({{"ndf", "vmf"}, {"lobes", 3}}).
ParameterValues bake_values(std::initializer_list<std::pair<const char*, ParameterValue>> values = {});

/// Replaces the job's values by the given values. If no storage encoding is given, uses the representation's default.
void apply(const ParameterValues& values, BakeJob& job);

/// Sets the job's region and file from `region` and `onto`. Throws Error(kUsage) if only one of them is given, or if
/// the region is neither "auto" nor of the form "x,y,width,height".
void apply_region(const ParameterValues& values, BakeJob& job);

/// Returns the representation that `ndf` names, or nullopt if `ndf` is not given.
std::optional<Representation> given_representation(const ParameterValues& values);

/// Returns the first given parameter that a target would choose, or null if there is none.
const Parameter* given_of_target(const ParameterValues& values);
/// Removes all parameters that a target chooses.
ParameterValues without_those_of_target(ParameterValues values);

/// Formats the values of representation, fit and storage as options of `multum bake`: "--ndf vmf --lobes 3".
std::string options_text(const ParameterValues& values);

/// Returns a given parameter that belongs to another representation than `ndf`, or null if there is none.
const Parameter* given_of_another_ndf(const ParameterValues& values);
/// Lists the values of --ndf to which the parameter applies: "for vmf and gmm".
std::string scope_text(const Parameter& parameter);
/// Throws Error(kUsage) for a parameter of another representation: "--lobes works only with --ndf vmf and gmm, found
/// --ndf sh".
void check_scopes(const ParameterValues& values);

}  // namespace multum
