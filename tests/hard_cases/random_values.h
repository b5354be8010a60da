// SPDX-License-Identifier: Apache-2.0
// Generates random values for the property tests in this folder.
#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>

namespace multum::testing {

// This must be set before the first property runs, because RapidCheck reads it at that time.
inline const int g_seeded = setenv("RC_PARAMS", "seed=20261122 max_success=300", 0);

// Generates numbers from 10^low to 10^high.
inline rc::Gen<double> decades(int low, int high) {
  return rc::gen::map(rc::gen::inRange(100 * low, 100 * high + 1), [](int e) { return std::pow(10.0, 0.01 * e); });
}

}  // namespace multum::testing
