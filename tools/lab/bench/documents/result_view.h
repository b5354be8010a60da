// SPDX-License-Identifier: Apache-2.0
// Contains the readable form of a benchmark's result, for the terminal and for docs/evidence/BENCHMARKS.md.
#pragma once

#include <string>

namespace multum::bench {

struct ResultView {
  std::string title;
  std::string method;  // a paragraph that describes the measurement
  std::string table;   // Markdown
};

}  // namespace multum::bench
