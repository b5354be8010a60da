// SPDX-License-Identifier: Apache-2.0
// Defines the types of jobs, which the program that runs the farm registers. Each type has a row and a table of
// parameters. The row and the table determine the requests that the web interface accepts, the options of `multum jobs
// submit`, and the command line of a worker. The row and the table also determine the files that the idempotency key
// covers, and the views of a result.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

class Progress;

/// Files that a child makes from a finished job's result at the first request (http/job_pictures.h). They are pictures,
/// or a page. The command line is `program` `words` --output=PLACE, the options named below, then -- and the result.
struct JobView {
  struct Shown {
    std::string file, caption;
    std::string saved_caption = {};  // caption of a page that can only be saved
  };
  std::vector<std::string> files;  // files made by one run; every successful run makes the first one
  std::string program = {};        // a program in the folder of this program, or in PATH; if empty, this program
  std::vector<std::string> words;  // first words of the command line
  bool writes_folder = false;      // PLACE is a folder, otherwise a file
  bool takes_roots = false;        // adds --root=FOLDER for each folder that jobs may read
  std::vector<std::pair<std::string, std::string>> maps = {};  // parameters of the job, each with the option that takes
                                                               // its file, if the file still exists
  std::string first_map_is_for = {};                           // why the view needs the first map; empty if it does not
  std::string folder_ending = {};  // ends the name of the view's folder; different for each view of a type
  std::size_t kept_max = 0;        // number of newest views that are kept; 0 means all
  std::vector<Shown> shown = {};   // files in the order of a job's page
  std::map<std::string, std::string> only_for = {};  // shown only if each of these parameters has the given value or is
                                                     // unset
};

/// An input that jobs of a type do not accept, although the command does.
struct RefusedInput {
  std::string extension;
  std::string expected;  // "a map, not a baked file"
};

struct JobType {
  std::string name;  // such as "bake"
  std::string summary;
  std::string command = {};  // command of this program that does the work; if empty, `run`
  /// Does the work within the worker. `arguments` come from job_arguments(). When `is_deaf` is set, the worker sends no
  /// more signs of life. Returns the exit code.
  std::function<int(const std::vector<std::string>& arguments, Progress& progress, std::atomic<bool>& is_deaf)> run =
      nullptr;
  std::string input = {};  // parameter that is the first argument; empty if there is none
  bool has_output = true;
  bool needs_output = true;
  bool output_is_folder = false;
  /// Lists the files that the input names, with paths relative to the input's folder, because a child process reads the
  /// input. Throws Error(kInput) when the input cannot be read. The function is null if the input names no files.
  std::vector<std::string> (*files_of_input)(const std::string& input) = nullptr;
  bool input_is_one_map = false;  // the input is one map, not a set of tiles
  std::vector<RefusedInput> refused_inputs = {};
  std::string output_extension = {};                 // "" means any extension
  std::vector<std::string> refused_extensions = {};  // file name extensions that an output folder must not have
  /// Options of every job of the type, such as --absolute-geometry. This option is needed because a result is made next
  /// to its final place and may be copied, so relative paths would break.
  std::vector<std::string> fixed_options = {};
  std::int64_t memory_bytes = 0;          // memory of a job whose submission does not state it
  const ParameterTable* table = nullptr;  // a job takes its kInService parameters
  std::vector<JobView> views = {};        // views of a finished job's result
  std::string no_other_view = {};         // why the type has no other views
  /// A command of this program that takes the arguments of `command`, --json and --share-seconds, and prints a job's
  /// estimated cost (slurm/slurm_estimate.h). If empty, `estimated_seconds` is used.
  std::string estimate_command = {};
  /// Returns the estimated seconds of a job. The function is null if they are unknown.
  double (*estimated_seconds)(const nlohmann::json& parameters) = nullptr;

  /// Returns null if jobs have no parameter of this name.
  const Parameter* find(const std::string& parameter) const;
  /// Returns null if no view makes a file of this name.
  const JobView* find_view(const std::string& file) const;
};

/// Registers the types of jobs that this program runs, in the order in which users and clients see them. Must be called
/// once, before any other function of the farm, because the farm itself has no types.
void register_job_types(std::vector<JobType> types);
/// Returns the registered types.
const std::vector<JobType>& job_types();
/// Throws Error(kUsage), which lists the registered names.
const JobType& find_job_type(std::string_view name);

/// The pattern that is_plain_text() checks, without the length limit.
inline constexpr const char* kPlainPattern = "^[^\\u0000-\\u001f\\u007f-\\u009f]*$";
/// Returns whether the text has up to 1000 characters of UTF-8 and no control character.
bool is_plain_text(const std::string& text);
/// Returns a value as shown in messages, at most 60 bytes.
std::string shortened(const nlohmann::json& value);

/// Checks names, types and ranges. Throws Error(kUsage), for example "parameters.lobes is 9, expected an integer from 1
/// to 8".
void check_parameters(const JobType& type, const nlohmann::json& parameters);
/// Throws Error(kUsage) for an input that the type's row excludes. A command may accept more than its jobs. For
/// example, `multum bake` accepts a scene and a pattern of names, whose files the daemon would not have checked.
void check_input(const JobType& type, const nlohmann::json& parameters);
/// Returns the schema (draft 2020-12) of the `parameters` object that check_parameters() accepts.
nlohmann::json parameters_schema(const JobType& type);

/// Parameters contain files as texts (path_text.h). The functions below use paths.

/// Returns the command line of `multum` that makes `output` from checked parameters.
std::vector<std::string> job_arguments(const JobType& type, const nlohmann::json& parameters,
                                       const std::string& output);

/// Returns every file whose content determines the result. These are the parameters' files, and the files that the
/// input names. Throws Error(kInput) when such an input cannot be read.
std::vector<std::string> input_files(const JobType& type, const nlohmann::json& parameters);

/// Returns a text that changes when any of input_files() is written, replaced or removed. This is fast, because no
/// contents are read. Returns "" if there are no inputs.
std::string input_identity(const JobType& type, const nlohmann::json& parameters);

/// Returns the SHA-256 of the type, the parameters without file names, the files' hashes and the version of multum. Two
/// jobs with the same key make the same bytes.
std::string idempotency_key(const JobType& type, const nlohmann::json& parameters,
                            const std::vector<std::string>& file_hashes);

}  // namespace multum
