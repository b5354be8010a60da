// SPDX-License-Identifier: Apache-2.0
// Measures elapsed seconds by a clock that is never set.
#pragma once

#include <chrono>

namespace multum::bench {

template <typename Body>
double milliseconds_of(const Body& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace multum::bench
