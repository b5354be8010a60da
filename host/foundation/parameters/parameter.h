// SPDX-License-Identifier: Apache-2.0
// Describes one parameter of a command. Each parameter is a row in a table (bake_parameters.h and similar files).
// Command lines, manifests, scene files, the service, the settings hash and docs/reference/commands.md use these rows.
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
  kFlag,     // true or false; on a command line, an option without a value
  kInteger,  // an integer in [low, high]
  kNumber,   // a finite number in [low, high]
  kChoice,   // one of `choices`
  kText,     // any text; the service rejects control characters
  kBrdf,     // a BRDF, such as "blinn-phong:100"; except in the service, it may also be the file of a measured BRDF
  kFile,     // the path of a file to read, or FILE:CHANNEL if `unit` says so
  kBytes,    // a size in [low, high]; a command line may add a unit, as in 800M
};

/// Bits for the places where users may give a parameter.
enum ParameterSurface : unsigned {
  kOnCommandLine = 1,
  kInManifest = 2,  // [defaults] and [[map]] of docs/reference/manifests.md
  kInScene = 4,     // [[map]] of docs/reference/scenes.md
  kInService = 8,   // parameters of a job of the service
};
constexpr unsigned kEverywhere = kOnCommandLine | kInManifest | kInScene | kInService;

/// The representations for which a parameter has an effect.
enum class ParameterScope { kAll, kLobes, kHarmonics };

/// The bound of numbers that have no other bound. It is the largest float.
constexpr double kUnbounded = static_cast<double>(std::numeric_limits<float>::max());

struct Parameter {
  std::string name;  // the name in snake case, which is the key in files and JSON; "--first-level" on a command line
  ParameterKind kind = ParameterKind::kFlag;
  std::string help;  // describes the effect; begins with a verb, without range and default
  double low = 0.0, high = 0.0;
  bool low_excluded = false, zero_excluded = false;
  // A unit, such as "texels" or "ms". For strings, files and long lists of choices, this is the form of a value, such
  // as "FILE[:CHANNEL]". It may be empty.
  std::string unit = {};
  std::string default_text = {};          // as written on a command line; empty if the parameter has no default
  std::vector<std::string> choices = {};  // in the order of help texts
  std::string group = {};                 // heading in help texts
  std::string hashed_as = {};     // key in multum:settings (docs/reference/file_format.md); empty if the parameter does
                                  // not change the content
  std::string short_option = {};  // "-d"
  std::vector<std::string> excludes = {};  // names of parameters that cannot be given together with this one
  ParameterScope scope = ParameterScope::kAll;
  bool chosen_by_target = false;  // true if target_error and budget_ms choose the value
  bool is_repeatable = false;     // may be repeated on a command line; the values are joined by ";"
  unsigned surfaces = 0;

  bool is_on(unsigned surface) const { return (surfaces & surface) != 0; }
  bool is_numeric() const {
    return kind == ParameterKind::kInteger || kind == ParameterKind::kNumber || kind == ParameterKind::kBytes;
  }
  /// Return true if the parameter is a number with a lower or an upper bound.
  bool has_low() const { return low > -kUnbounded; }
  bool has_high() const { return high < kUnbounded; }
  /// Returns the option, such as "--first-level".
  std::string option() const;
};

/// Returns the option for a parameter name: "--first-level" for "first_level".
std::string option_of(const std::string& name);

/// The type of the value is bool for kFlag, int64 for kInteger and kBytes, double for kNumber, and string for all
/// others.
using ParameterValue = std::variant<bool, std::int64_t, double, std::string>;

/// Describes the legal values, as in "an integer from 1 to 8" or "one of colour, scanline".
std::string expected_text(const Parameter& parameter);

/// Returns the value as text, such as 9, true or "waves".
std::string value_text(const ParameterValue& value);
/// Returns the value as text. A size that is a whole number of MiB is written like "288 MiB".
std::string value_text(const Parameter& parameter, const ParameterValue& value);

/// Returns whether the value has the type of the parameter and is legal.
bool is_legal(const Parameter& parameter, const ParameterValue& value);

/// Returns the number of bytes of "800M", "2G" or "38K" (1024-based) or of a plain number. Returns nullopt for other
/// texts.
std::optional<std::int64_t> parse_size_text(const std::string& text);

/// Parses the text of a command-line value. kBytes accepts a unit, such as 800M or 2G (1024-based). Returns nullopt for
/// text that does not have the parameter's type. The range is not checked here, but by is_legal().
std::optional<ParameterValue> parse_value(const Parameter& parameter, const std::string& text);

/// The parameters of one command.
class ParameterTable {
 public:
  ParameterTable(std::string command, std::vector<Parameter> rows);
  /// Returns the name that is used on command lines and as a job type, such as "bake".
  const std::string& command() const { return command_; }
  const std::vector<Parameter>& rows() const { return rows_; }
  /// Returns the row with this name, or null.
  const Parameter* find(const std::string& name) const;
  /// Returns the row with this name, which must exist.
  const Parameter& at(const std::string& name) const;
  /// Returns the names of the parameters that may be given at `surface`, in the order of the table.
  std::vector<std::string> names(unsigned surface) const;

 private:
  std::string command_;
  std::vector<Parameter> rows_;
};

}  // namespace multum
