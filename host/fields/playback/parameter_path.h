// SPDX-License-Identifier: Apache-2.0
// A path through the parameters of a field, written down: 'view=0..63,light=4+3*sin(t)'. Each parameter has an
// expression of the time, or a range that it runs through from the path's begin to its end.
//
//      path    name = value [, name = value ...]        names are the field's parameters; what is not named stays 0
//      value   sum [.. sum]                             a..b: a + (b - a) of the path's share that has passed
//      sum     product [+ product | - product ...]
//      product factor [* factor | / factor ...]
//      factor  number | t | pi | ( sum ) | sin ( sum ) | cos ( sum ) | - factor
#pragma once

#include <string>
#include <vector>

namespace multum {

/// When something is on a path.
struct PathTime {
  double seconds = 0.0;  // t
  double share = 0.0;    // 0 at the begin, 1 at the end
};

class ParameterPath {
 public:
  /// `names`: the field's parameters. Throws Error(kUsage) saying what was found where, and what was expected.
  ParameterPath(const std::string& text, const std::vector<std::string>& names);

  /// The value of every parameter. Throws Error(kUsage) where one is not finite.
  std::vector<double> at(const PathTime& time) const;

 private:
  friend class PathParser;

  enum class Kind { kNumber, kTime, kAdd, kSubtract, kMultiply, kDivide, kNegate, kSin, kCos, kBetween };
  struct Step {
    Kind kind;
    double number = 0.0;
  };

  std::vector<std::string> names_;
  std::vector<std::vector<Step>> values_;  // of each parameter, operands before what is done to them; none: 0
};

}  // namespace multum
