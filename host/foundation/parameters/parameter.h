// SPDX-License-Identifier: Apache-2.0
// Describes one parameter of a command. A row of a table (bake_parameters.h and its neighbours) is all that command
// lines, manifests, scene files, the service, the settings hash and docs/reference/parameters.md know of it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace multum {

enum class ParameterKind {
  kFlag,     // true or false; on a command line given or not
  kInteger,  // in [low, high]
  kNumber,   // in [low, high], finite
  kChoice,   // one of `choices`
  kText,     // any text; the service takes no control characters
  kBrdf,     // "blinn-phong:100"; the file of a measured one, too, except in the service
  kFile,     // path of a file to read, FILE:CHANNEL where `unit` says so
  kBytes,    // in [low, high]; on a command line with a unit, 800M
};

/// Bits: where a parameter may be given.
enum ParameterSurface : unsigned {
  kOnCommandLine = 1,
  kInManifest = 2,  // [defaults] and [[map]] of docs/reference/manifests.md
  kInScene = 4,     // [[map]] of docs/reference/scenes.md
  kInService = 8,   // parameters of a job
};
constexpr unsigned kEverywhere = kOnCommandLine | kInManifest | kInScene | kInService;

/// What a bake must store for the parameter to mean anything.
enum class ParameterScope { kAll, kLobes, kHarmonics };

/// Bound of numbers that have none: all that a float holds.
constexpr double kUnbounded = std::numeric_limits<float>::max();

struct Parameter {
  std::string name;  // snake case: the key of files and JSON; "--first-level" on a command line
  ParameterKind kind = ParameterKind::kFlag;
  std::string help;  // what it does, in words that need neither its range nor its default
  double low = 0.0, high = 0.0;
  bool low_excluded = false, zero_excluded = false;
  // "texels", "ms"; of texts, files and long choices their form, "FILE[:CHANNEL]"; empty: none.
  std::string unit = {};
  std::string default_text = {};          // as a command line has it; empty: none
  std::vector<std::string> choices = {};  // in the order in which they are shown
  std::string group = {};                 // heading of help texts
  std::string hashed_as = {};     // key of multum:settings (docs/reference/file_format.md); empty: changes no content
  std::string short_option = {};  // "-d"
  std::vector<std::string> excludes = {};  // names of others that cannot be given beside it
  ParameterScope scope = ParameterScope::kAll;
  bool chosen_by_target = false;  // target_error and budget_ms choose it
  bool is_repeatable = false;     // on a command line; the values are joined by ";"
  unsigned surfaces = 0;

  bool is_on(unsigned surface) const { return (surfaces & surface) != 0; }
  bool is_numeric() const {
    return kind == ParameterKind::kInteger || kind == ParameterKind::kNumber || kind == ParameterKind::kBytes;
  }
  /// Are numbers bounded there?
  bool has_low() const { return low > -kUnbounded; }
  bool has_high() const { return high < kUnbounded; }
  /// "--first-level".
  std::string option() const;
};

/// The option of a parameter's name: "--first-level" of "first_level".
std::string option_of(const std::string& name);

/// kFlag: bool; kInteger and kBytes: int64; kNumber: double; all others: text.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// What is legal, in words: "an integer from 1 to 8", "one of colour, scanline".
std::string expected_text(const Parameter& parameter);

/// The value in words: 9, true, "waves".
std::string value_text(const ParameterValue& value);
/// The same of a parameter's value: sizes in MiB where they are whole ones.
std::string value_text(const Parameter& parameter, const ParameterValue& value);

/// Is the value of the parameter's type, and legal?
bool is_legal(const Parameter& parameter, const ParameterValue& value);

/// Bytes of "800M", "2G", "38K" (1024-based), or a number alone; nothing where it is no size.
std::optional<std::int64_t> parse_size_text(const std::string& text);

/// Reads the text of a command line; a kBytes may have a unit, 800M or 2G (1024-based). Returns nothing where the text
/// is not of the parameter's type; whether the value is legal is_legal() tells.
std::optional<ParameterValue> parse_value(const Parameter& parameter, const std::string& text);

/// The parameters of one command.
class ParameterTable {
 public:
  ParameterTable(std::string command, std::vector<Parameter> rows);
  /// "bake": its name on command lines and as a job's type.
  const std::string& command() const { return command_; }
  const std::vector<Parameter>& rows() const { return rows_; }
  /// The row of this name; null: there is none.
  const Parameter* find(const std::string& name) const;
  /// The same; the row must be there.
  const Parameter& at(const std::string& name) const;
  /// Names of those that may be given there, in the table's order.
  std::vector<std::string> names(unsigned surface) const;

 private:
  std::string command_;
  std::vector<Parameter> rows_;
};

}  // namespace multum
