// SPDX-License-Identifier: Apache-2.0
// Measures elapsed seconds with a clock that is never adjusted.
#pragma once

#include "host/foundation/base/stopwatch.h"

namespace multum::bench {

template <typename Body>
double milliseconds_of(const Body& body) {
  const Stopwatch stopwatch;
  body();
  return 1e3 * stopwatch.seconds();
}

}  // namespace multum::bench
