// SPDX-License-Identifier: Apache-2.0
// Searches for the lambda at which a packed field has the requested size or error. If neither is requested, the search
// starts from a default ratio and lowers it if the error would be too large. The default ratio gives fields of few
// samples too few bytes, so their error would be too large.
#pragma once

#include <optional>

#include "host/fields/codec/packing/field_coder.h"

namespace multum {

/// At most one of the four members is set. If none is set, the target is a ratio of kDefaultRatio, or the error of
/// error_limit() if that ratio gives a larger error.
struct FieldTarget {
  std::optional<double> ratio;   // least ratio of the size of raw 24-bit frames to the file size
  std::optional<double> bytes;   // largest file size in bytes
  std::optional<double> mse;     // upper limit of the estimated squared error that coding adds to drawn frames, in
                                 // 8-bit units at gamma 2.2
  std::optional<double> lambda;  // the squared error that justifies one bit, summed over pixels and colours

  bool is_default() const { return !ratio && !bytes && !mse && !lambda; }
};

constexpr double kDefaultRatio = 384.0;
/// By default, packing adds less than this multiple of the inferred textures' error to drawn frames.
constexpr double kAddedErrorMax = 3.0;

/// Returns the error that packing may add, as in FieldTarget::mse, so that the added error stays below kAddedErrorMax
/// times the inferred textures' error. `inferred_mse` is the error over all pixels of all frames, in 8-bit sRGB units.
double error_limit(double inferred_mse);

struct FieldMeasure {
  double raw_bytes = 0.0;         // size of the 24-bit frames
  std::optional<double> mse_max;  // result of error_limit(); if unset, the limit is unknown and the ratio is not
                                  // lowered
};

/// Codes the field for the target. The search starts at `lambda`. Throws Error(kUsage) if a requested size or error
/// cannot be met. If a default target cannot be met, returns the nearest result.
FieldRound coded_for(const FieldTarget& target, const FieldMeasure& measure, double lambda, FieldCoder& coder);

}  // namespace multum
