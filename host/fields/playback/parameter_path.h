// SPDX-License-Identifier: Apache-2.0
// Parses a path through the parameters of a field: 'view=0..63,light=4+3*sin(t)'. Each parameter is given by an
// expression of the time, or by a range that it runs through during the path.
//
//      path    name = value [, name = value ...]        names are the field's parameters; others stay 0
//      value   sum [.. sum]                             a..b: a + (b - a) * (share of the path that has passed)
//      sum     product [+ product | - product ...]
//      product factor [* factor | / factor ...]
//      factor  number | t | pi | ( sum ) | sin ( sum ) | cos ( sum ) | - factor
#pragma once

#include <string>
#include <vector>

namespace multum {

/// A moment on a path.
struct PathTime {
  double seconds = 0.0;  // t
  double share = 0.0;    // 0 at the beginning, 1 at the end
};

class ParameterPath {
 public:
  /// `names` are the field's parameters. Throws Error(kUsage) with the position, the text found and the text expected.
  ParameterPath(const std::string& text, const std::vector<std::string>& names);

  /// Returns the value of every parameter. Throws Error(kUsage) if one is not finite.
  std::vector<double> at(const PathTime& time) const;

 private:
  friend class PathParser;

  enum class Kind { kNumber, kTime, kAdd, kSubtract, kMultiply, kDivide, kNegate, kSin, kCos, kBetween };
  struct Step {
    Kind kind;
    double number = 0.0;
  };

  std::vector<std::string> names_;
  std::vector<std::vector<Step>> values_;  // steps of each parameter, operands before their operators; without steps
                                           // the value is 0
};

}  // namespace multum
