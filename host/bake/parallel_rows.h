// SPDX-License-Identifier: Apache-2.0
// Runs body(row) for every row on some threads. Rows are independent, so the result does not depend on the count.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace multum {

template <typename Body>
void parallel_rows(int row_count, int threads, const Body& body) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int row = next++; row < row_count; row = next++) body(row);
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < threads && t < row_count; ++t) helpers.emplace_back(work);
  work();
}

}  // namespace multum
