// SPDX-License-Identifier: Apache-2.0
// Makes docs/evidence/BENCHMARKS.md of results: a section each, with its command and the conditions it was measured
// under.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct BenchmarksDocumentOptions {
  std::string output;                // Markdown file
  std::vector<std::string> results;  // files of --json, in the document's order
  bool allow_dirty = false;          // although some were measured with sources that are not committed
};

/// Throws Error(kInput) that names a file which is no result, Error(kUsage) for one of sources that are not committed.
int write_benchmarks_document(const BenchmarksDocumentOptions& options);

}  // namespace multum::bench
