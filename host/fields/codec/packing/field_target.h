// SPDX-License-Identifier: Apache-2.0
// Searches for the worth of a bit at which a packed field has the size, or the error, that was asked for. Where neither
// was asked for, the ratio gives way to the error: a field of few samples has too few bytes at a ratio that suits many.
#pragma once

#include <optional>

#include "host/fields/codec/packing/field_coder.h"

namespace multum {

/// At most one of the four is given. None: a ratio of kDefaultRatio, or the error of error_limit() where the ratio
/// would leave more.
struct FieldTarget {
  std::optional<double> ratio;   // bytes of raw 24-bit frames over the file's, at least
  std::optional<double> bytes;   // of the file, at most
  std::optional<double> mse;     // estimated, that coding adds to drawn frames, at most; 8-bit units at gamma 2.2
  std::optional<double> lambda;  // squared error that a bit is worth, summed over pixels and colours

  bool is_default() const { return !ratio && !bytes && !mse && !lambda; }
};

constexpr double kDefaultRatio = 384.0;
/// What packing adds to drawn frames stays below so many times the error of the inferred textures by default.
constexpr double kAddedErrorMax = 3.0;

/// What packing may add, as FieldTarget::mse has it, so that it stays below kAddedErrorMax times the error of the
/// inferred textures. `inferred_mse`: over all pixels of all frames, 8-bit sRGB units.
double error_limit(double inferred_mse);

struct FieldMeasure {
  double raw_bytes = 0.0;         // of 24-bit frames
  std::optional<double> mse_max;  // error_limit(); none: it is not known, and nothing gives way
};

/// Codes for the target; `lambda`: where the search begins. Throws Error(kUsage) for a size or an error that was asked
/// for and cannot be met. By default what cannot be met is as near to it as was found.
FieldRound coded_for(const FieldTarget& target, const FieldMeasure& measure, double lambda, FieldCoder& coder);

}  // namespace multum
