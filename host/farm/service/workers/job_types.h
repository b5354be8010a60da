// SPDX-License-Identifier: Apache-2.0
// The types of jobs, as the program that runs the farm has registered them. What the web interface accepts, what
// `multum jobs submit` takes as options, which command line a worker runs, which files the idempotency key is of and
// what shows a result follow from each type's row and its table of parameters.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

class Progress;

/// Files that a child makes of a finished job's result when they are first asked for (http/job_pictures.h): pictures,
/// or a page. Its command line is `program` `words` --output=PLACE and what else is said here, then -- and the result.
struct JobView {
  struct Shown {
    std::string file, caption;
    std::string saved_caption = {};  // of a page, where it can only be saved
  };
  std::vector<std::string> files;  // of one run; whenever it does its work it makes the first
  std::string program = {};        // beside this program or in PATH; empty: this program
  std::vector<std::string> words;  // that its command line begins with
  bool writes_folder = false;      // PLACE is a folder, else its one file
  bool takes_roots = false;        // --root=FOLDER, for each that jobs may read
  std::vector<std::pair<std::string, std::string>> maps = {};  // parameters of the job, each with the option that takes
                                                               // its file, as long as the file is there
  std::string first_map_is_for = {};  // why it cannot do without the first of them; empty: it can
  std::string folder_ending = {};     // of the folder that keeps it: views of one type have different ones
  std::size_t kept_max = 0;           // only the last so many are kept; 0: all
  std::vector<Shown> shown = {};      // on the page of a job, in order
  std::map<std::string, std::string> only_for = {};  // on it, where these parameters have these values or none
};

/// An input that jobs of a type do not take although a command line would.
struct RefusedInput {
  std::string extension;
  std::string expected;  // "a map, not a baked file"
};

struct JobType {
  std::string name;  // "bake"
  std::string summary;
  std::string command = {};  // of this program, that does it; empty: `run`
  /// Does it in the worker itself. `arguments`: as job_arguments() makes them; `is_deaf`: set, the worker says no more
  /// that it lives. Returns the exit code.
  std::function<int(const std::vector<std::string>& arguments, Progress& progress, std::atomic<bool>& is_deaf)> run =
      nullptr;
  std::string input = {};  // name of the parameter that is the first argument; empty: none
  bool has_output = true;
  bool needs_output = true;
  bool output_is_folder = false;
  /// Lists the files that the input names, relative to itself: it is read in a child, and its place matters. Throws
  /// Error(kInput) when it cannot be read. Null: an input names none.
  std::vector<std::string> (*files_of_input)(const std::string& input) = nullptr;
  bool input_is_one_map = false;  // no set of tiles
  std::vector<RefusedInput> refused_inputs = {};
  std::string output_extension = {};                 // "" any
  std::vector<std::string> refused_extensions = {};  // of a folder's name that would be taken for a file's
  /// That every job of the type has. --absolute-geometry: a result is made beside its place and may be copied to
  /// another, so that no path relative to it would hold.
  std::vector<std::string> fixed_options = {};
  std::int64_t memory_bytes = 0;          // that a job is taken to need when it does not say
  const ParameterTable* table = nullptr;  // of which a job takes those that are kInService
  std::vector<JobView> views = {};        // of a finished job's result
  std::string no_other_view = {};         // why there is none but those
  /// A command of this program that takes what `command` does, with --json and --share-seconds, and prints what the job
  /// takes (slurm/slurm_estimate.h). Empty: `estimated_seconds`.
  std::string estimate_command = {};
  /// Null: nothing is known.
  double (*estimated_seconds)(const nlohmann::json& parameters) = nullptr;

  /// Null: a job takes none of this name.
  const Parameter* find(const std::string& parameter) const;
  /// Null: there is none that makes a file of this name.
  const JobView* find_view(const std::string& file) const;
};

/// Hands the farm the types of jobs that this program runs, in the order in which people and clients see them. Once,
/// before anything else of the farm: the farm itself knows none.
void register_job_types(std::vector<JobType> types);
/// Those that were registered.
const std::vector<JobType>& job_types();
/// Throws Error(kUsage) naming those that there are.
const JobType& find_job_type(const std::string& name);

/// What is_plain_text() takes, but for its length.
inline constexpr const char* kPlainPattern = "^[^\\u0000-\\u001f\\u007f-\\u009f]*$";
/// Up to 1000 characters of UTF-8, none of them a control character.
bool is_plain_text(const std::string& text);
/// A value as messages show it, 60 bytes of it at most.
std::string shortened(const nlohmann::json& value);

/// Checks names, types and ranges. Throws Error(kUsage): "parameters.lobes is 9, expected an
/// integer from 1 to 8".
void check_parameters(const JobType& type, const nlohmann::json& parameters);
/// A command may take more than its jobs do, as `multum bake` takes a scene and a pattern of names, whose files nobody
/// would have looked at: throws Error(kUsage) for an input that the type's row refuses.
void check_input(const JobType& type, const nlohmann::json& parameters);
/// Draft 2020-12, of the `parameters` object: what check_parameters() accepts.
nlohmann::json parameters_schema(const JobType& type);

/// In parameters files are texts (path_text.h), in what follows they are paths.

/// The command line of `multum` that makes `output` of checked parameters.
std::vector<std::string> job_arguments(const JobType& type, const nlohmann::json& parameters,
                                       const std::string& output);

/// Every file whose content decides the result: the parameters' own, and those that the input names. Throws
/// Error(kInput) when such an input cannot be read.
std::vector<std::string> input_files(const JobType& type, const nlohmann::json& parameters);

/// Changes when any of input_files() is written, replaced or removed; cheap: contents are not read. Empty: no inputs.
std::string input_identity(const JobType& type, const nlohmann::json& parameters);

/// SHA-256 of the type, the parameters without the names of files, the files' hashes and the version of multum; two
/// jobs of one key make the same bytes.
std::string idempotency_key(const JobType& type, const nlohmann::json& parameters,
                            const std::vector<std::string>& file_hashes);

}  // namespace multum
