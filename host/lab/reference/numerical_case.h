// SPDX-License-Identifier: Apache-2.0
// A named numerical case: one hard input, or a family of them, of one kernel or shader function, in single precision
// against double precision, with a stated bound. docs/contributing/STABILITY.md is made of them.
//
// The end of the project's list of hard cases (kappa at its ends, dead lobes, sums over 2^28 texels, and so on) is
// where they come from. Each names the guard that the formula has for the case, and can be run with that guard taken
// out, or with a bug put in: a mutation, where no single line is the guard.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/source_edit.h"

namespace multum {

/// The bound of cases that count what is wrong, or that must be exact: nothing may be.
constexpr double kNothingWrong = 1e-30;

/// What a case says of itself.
struct NumericalCaseText {
  std::string name;           // unique, lower case, words joined by '-'
  std::string formula;        // the kernels or shaders that it is of: "movmf_em_texels", "ggx.glsl, terms.glsl"
  std::string without_guard;  // what happens without the guard, in words
  std::string guard;          // what is done about it
  double bound;               // of the error, > 0
  std::string unit;           // of the error: "relative", "of the peak"
  std::string bound_reason;   // where the bound comes from
};

/// The worst error of a case so far, and the input that it was at. An error that is not a number is worse than any.
class WorstError {
 public:
  void add(double error, const std::string& input);
  /// |found - expected| / unit.
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
  double worst;                         // NaN: not a number was found
  std::string worst_input;              // where
  std::optional<double> without_guard;  // the worst error with the guard taken out, or of the naive formula in float
  std::optional<double> mutated = {};   // the worst error with a bug in
  bool holds() const { return worst <= text.bound; }
  /// Did what was tried, taking the guard out or a bug, break the bound? False too when nothing was.
  bool can_fail() const {
    return (without_guard || mutated) && !(without_guard && *without_guard <= text.bound) &&
           !(mutated && *mutated <= text.bound);
  }
};

/// The verdicts of one device, or of one GL.
struct NumericalRun {
  std::string kind;      // "OpenCL" or "GL"
  std::string device;    // name
  std::string platform;  // OpenCL's platform, GL's vendor
  std::string driver;    // version
  std::string software;  // "multum 0.1.0"
  std::vector<NumericalVerdict> verdicts;
  bool holds() const;
};

/// The error that says least of the guards' need: the smaller, a number before what is none.
double least_error(double a, double b);

/// What is wrong with a case's edits, or nothing: each of `without` takes one guard out by itself, so that it changes
/// more than a number (a guard that is larger or smaller is a bug put in).
std::string fault_of_guards(const std::vector<SourceEdit>& without);

/// The kernels or shaders of a case's `formula`, without what stands in brackets behind one: "movmf_shade (planar)".
std::vector<std::string> split_names(const std::string& formula);

/// "3.1e-07", "NaN", "inf".
std::string error_text(double error);
/// The same, "-" of what was not tried.
std::string tried_text(const std::optional<double>& error);
/// The same of a bound: "0" where it is kNothingWrong.
std::string bound_text(double bound);

}  // namespace multum
