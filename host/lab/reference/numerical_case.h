// SPDX-License-Identifier: Apache-2.0
// Describes a numerical case, which tests one kernel or shader function with one hard input or a family of hard inputs.
// A case compares results in single precision with results in double precision, and states a bound.
// docs/contributing/STABILITY.md is generated from the cases.
//
// The cases cover the project's hard inputs, such as extreme kappa, dead lobes, and sums over 2^28 texels. Each case
// names the guard of the formula. A case can be run without its guard. If the guard is not a single line, the case can
// be run with a bug, which is called a mutation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/source_edit.h"

namespace multum {

/// The bound of cases that count faults or require exact results. It means that the error must be 0.
constexpr double kNothingWrong = 1e-30;

/// The texts and the bound of a case.
struct NumericalCaseText {
  std::string name;           // unique name in lower case, with words joined by '-'
  std::string formula;        // the kernels or shaders tested: "movmf_em_texels", "ggx.glsl, terms.glsl"
  std::string without_guard;  // the failure without the guard, in words
  std::string guard;          // the guard, in words
  double bound;               // largest allowed error, > 0
  std::string unit;           // unit of the error, such as "relative error" or "of the peak"
  std::string bound_reason;   // reason for the bound
};

/// Contains the worst error of a case so far, and the input that caused it. NaN counts as worse than any other error.
class WorstError {
 public:
  void add(double error, const std::string& input);
  /// Adds the error |found - expected| / unit.
  void add(double found, double expected, double unit, const std::string& input);
  double value() const { return value_; }
  const std::string& input() const { return input_; }
  std::size_t count() const { return count_; }

 private:
  double value_ = 0.0;
  std::string input_;
  std::size_t count_ = 0;
};

struct NumericalVerdict {
  NumericalCaseText text;
  double worst;                         // worst error; NaN if any result was NaN
  std::string worst_input;              // input that caused the worst error
  std::optional<double> without_guard;  // the worst error without the guard, or the worst error of the naive formula in
                                        // float
  std::optional<double> mutated = {};   // the worst error with a bug
  bool holds() const { return worst <= text.bound; }
  /// Returns true if every run without the guard or with the bug exceeded the bound. Returns false if no such run was
  /// made.
  bool can_fail() const {
    return (without_guard || mutated) && !(without_guard && *without_guard <= text.bound) &&
           !(mutated && *mutated <= text.bound);
  }
};

/// The verdicts of one device or one GL implementation.
struct NumericalRun {
  std::string kind;      // "OpenCL" or "GL"
  std::string device;    // name of the device
  std::string platform;  // platform of OpenCL, or vendor of GL
  std::string driver;    // version of the driver
  std::string software;  // such as "multum 0.1.0"
  std::vector<NumericalVerdict> verdicts;
  bool holds() const;
};

/// Returns the smaller of two errors, because it is the weaker evidence that the guards are needed. Any number counts
/// as smaller than NaN.
double least_error(double a, double b);

/// Returns the reason why a case's edits are wrong, or an empty string if they are correct. Each edit in `without` must
/// remove one guard. An edit that only changes a number is a mutation.
std::string fault_of_guards(const std::vector<SourceEdit>& without);

/// Lists the kernels or shaders in a case's `formula`. Omits additions in brackets, such as the one in "movmf_shade
/// (planar)".
std::vector<std::string> split_names(const std::string& formula);

/// Formats an error, such as "3.1e-07", "NaN" or "inf".
std::string error_text(double error);
/// Formats an error. Returns "-" if the error was not measured.
std::string tried_text(const std::optional<double>& error);
/// Formats a bound. kNothingWrong becomes "0".
std::string bound_text(double bound);

}  // namespace multum
