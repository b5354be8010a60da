// SPDX-License-Identifier: Apache-2.0
// A named numerical case: one hard input, or a family of them, of one kernel or shader function, in single precision
// against double precision, with a stated bound. docs/STABILITY.md is made of them.
//
// The end of the project's list of hard cases (kappa at its ends, dead lobes, sums over 2^28 texels, and so on) is
// where they come from. Each names the guard that the formula has for the case, and can be run with that guard taken
// out.
#pragma once

#include <optional>
#include <string>
#include <vector>

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
  bool holds() const { return worst <= text.bound; }
  /// Did taking the guard out break the bound? False too when it was not tried.
  bool guard_matters() const { return without_guard && !(*without_guard <= text.bound); }
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

/// The kernels or shaders of a case's `formula`, without what stands in brackets behind one: "movmf_shade (planar)".
std::vector<std::string> split_names(const std::string& formula);

/// "3.1e-07", "NaN", "inf".
std::string error_text(double error);
/// The same of a bound: "0" where it is kNothingWrong.
std::string bound_text(double bound);

}  // namespace multum
