// SPDX-License-Identifier: Apache-2.0
// Computes the Charlie sheen in double precision, in its simplest form. The distribution is from Estevez and Kulla
// 2017, where alpha is called r. The visibility V is from Ashikhmin and Premoze 2007.
#pragma once

#include <cmath>
#include <numbers>

namespace multum::reference {

/// Returns the density per solid angle at the angle `theta` (radians) from the normal.
inline double charlie(double alpha, double theta) {
  if (theta >= 0.5 * std::numbers::pi) return 0.0;
  return (2.0 + 1.0 / alpha) * std::pow(std::sin(theta), 1.0 / alpha) / (2.0 * std::numbers::pi);
}

/// Returns the visibility G / (4 n.l n.v).
inline double sheen_visibility(double n_l, double n_v) { return 1.0 / (4.0 * (n_l + n_v - n_l * n_v)); }

}  // namespace multum::reference
