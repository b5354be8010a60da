// SPDX-License-Identifier: Apache-2.0
// Draws random values for the properties of this folder.
#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>

namespace multum::testing {

// Must be set before the first property runs, because RapidCheck reads it then.
inline const int g_seeded = setenv("RC_PARAMS", "seed=20261122 max_success=300", 0);

// Generates numbers from 10^low to 10^high.
inline rc::Gen<double> decades(int low, int high) {
  return rc::gen::map(rc::gen::inRange(100 * low, 100 * high + 1), [](int e) { return std::pow(10.0, 0.01 * e); });
}

}  // namespace multum::testing
