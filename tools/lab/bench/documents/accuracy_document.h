// SPDX-License-Identifier: Apache-2.0
// Makes docs/evidence/ACCURACY.md: every figure of it, on the four-quarter map and on the normal maps of a folder.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct AccuracyDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of real maps; empty: none
  std::string brdfs;   // folder of measured BRDFs; empty: none
  // Of kSections: these alone are made, and take the place of those of a document that is there; empty: all are.
  std::vector<std::string> sections;
  std::string commit;        // named in the document
  bool is_quick = false;     // sweep few settings, which shows that the page can be made
  bool allow_dirty = false;  // although `commit` is not that of a committed tree
  int size = 1024;           // side of the four-quarter map
  int threads = 2;
};

constexpr const char* kSections[] = {"quarters", "representations", "formulas", "maps"};

int write_accuracy_document(const AccuracyDocumentOptions& options);

}  // namespace multum::bench
