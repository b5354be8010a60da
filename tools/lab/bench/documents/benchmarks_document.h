// SPDX-License-Identifier: Apache-2.0
// Writes docs/evidence/BENCHMARKS.md from results: one section each, with its command and conditions.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct BenchmarksDocumentOptions {
  std::string output;                // Markdown file
  std::vector<std::string> results;  // files from --json, in the document's order
  bool allow_dirty = false;          // accept results of sources that are not committed
};

/// Throws Error(kInput) that names a file without a result, and Error(kUsage) for results of uncommitted sources.
int write_benchmarks_document(const BenchmarksDocumentOptions& options);

}  // namespace multum::bench
