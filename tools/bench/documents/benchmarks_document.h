// SPDX-License-Identifier: Apache-2.0
// Makes docs/BENCHMARKS.md of results: a section each, with its command and the conditions it was measured under.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct BenchmarksDocumentOptions {
  std::string output;                // Markdown file
  std::vector<std::string> results;  // files of --json, in the document's order
};

/// Throws Error(kInput) that names a file which is no result.
int write_benchmarks_document(const BenchmarksDocumentOptions& options);

}  // namespace multum::bench
