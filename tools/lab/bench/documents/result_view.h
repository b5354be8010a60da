// SPDX-License-Identifier: Apache-2.0
// A benchmark's result as people read it: on a terminal after a run, and in docs/evidence/BENCHMARKS.md.
#pragma once

#include <string>

namespace multum::bench {

struct ResultView {
  std::string title;
  std::string method;  // what was measured, a paragraph
  std::string table;   // Markdown
};

}  // namespace multum::bench
