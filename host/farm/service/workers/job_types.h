// SPDX-License-Identifier: Apache-2.0
// Lists the types of jobs. What the web interface accepts, what `multum submit` takes as options, which command line a
// worker runs and which files the idempotency key is of follow from each type's table of parameters.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

struct JobType {
  std::string name;  // "bake"
  std::string summary;
  std::string command = {};  // of multum, that does it; empty: the worker itself does
  std::string input = {};    // name of the parameter that is the first argument; empty: none
  bool has_output = true;
  bool needs_output = true;
  bool output_is_folder = false;
  bool input_names_files = false;                    // relative to itself: it is read in a child, and its place matters
  std::string output_extension = {};                 // "" any
  std::vector<std::string> refused_extensions = {};  // of a folder's name that would be taken for a file's
  /// That every job of the type has. --absolute-geometry: a result is made beside its place and may be copied to
  /// another, so that no path relative to it would hold.
  std::vector<std::string> fixed_options = {};
  std::int64_t memory_bytes = 0;          // that a job is taken to need when it does not say
  const ParameterTable* table = nullptr;  // of which a job takes those that are kInService

  /// Null: a job takes none of this name.
  const Parameter* find(const std::string& parameter) const;
};

/// bake, scene, infer, pack, export, and drill: a job that does nothing, or fails as asked, for trying out a set-up.
const std::vector<JobType>& job_types();
/// Throws Error(kUsage) naming those that there are.
const JobType& find_job_type(const std::string& name);

/// Up to 1000 characters of UTF-8, none of them a control character.
bool is_plain_text(const std::string& text);
/// A value as messages show it, 60 bytes of it at most.
std::string shortened(const nlohmann::json& value);

/// Checks names, types and ranges. Throws Error(kUsage): "parameters.lobes is 9, expected an
/// integer from 1 to 8".
void check_parameters(const JobType& type, const nlohmann::json& parameters);
/// `multum bake` takes a scene too, and a pattern of names, whose files nobody would have looked at: throws
/// Error(kUsage) when the input of a bake or an export is no single map.
void check_is_one_map(const JobType& type, const nlohmann::json& parameters);
/// Draft 2020-12, of the `parameters` object: what check_parameters() accepts.
nlohmann::json parameters_schema(const JobType& type);

/// In parameters files are texts (path_text.h), in what follows they are paths.

/// The command line of `multum` that makes `output` of checked parameters.
std::vector<std::string> job_arguments(const JobType& type, const nlohmann::json& parameters,
                                       const std::string& output);

/// Every file whose content decides the result: the parameters' own, and those that a scene or a job of inference
/// names.
/// Throws Error(kInput) when such a job cannot be read.
std::vector<std::string> input_files(const JobType& type, const nlohmann::json& parameters);

/// Changes when any of input_files() is written, replaced or removed; cheap: contents are not read. Empty: no inputs.
std::string input_identity(const JobType& type, const nlohmann::json& parameters);

/// SHA-256 of the type, the parameters without the names of files, the files' hashes and the version of multum; two
/// jobs of one key make the same bytes.
std::string idempotency_key(const JobType& type, const nlohmann::json& parameters,
                            const std::vector<std::string>& file_hashes);

}  // namespace multum
