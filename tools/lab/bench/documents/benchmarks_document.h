// SPDX-License-Identifier: Apache-2.0
// Writes docs/evidence/BENCHMARKS.md from results. Each section contains one result, with its command and conditions.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct BenchmarksDocumentOptions {
  std::string output;                // Markdown file
  std::vector<std::string> results;  // result files of --json, in the order of the sections
  bool allow_dirty = false;          // accept results of uncommitted sources
};

/// If a file contains no result, throws an Error(kInput) that names the file. Throws Error(kUsage) for results of
/// uncommitted sources.
int write_benchmarks_document(const BenchmarksDocumentOptions& options);

}  // namespace multum::bench
