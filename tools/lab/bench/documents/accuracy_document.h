// SPDX-License-Identifier: Apache-2.0
// Writes docs/evidence/ACCURACY.md from measurements on the four-quarter map and on the normal maps of a folder.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct AccuracyDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of real maps; empty: none
  std::string brdfs;   // folder of measured BRDFs; empty: none
  // Sections to make, from kSections; other sections of an existing document stay as they are. Empty: all.
  std::vector<std::string> sections;
  std::string commit;        // named in the document
  bool is_quick = false;     // sweep few settings, only to show that the page can be made
  bool allow_dirty = false;  // accept a `commit` that is not a committed tree
  int size = 1024;           // side of the four-quarter map
  int threads = 2;
};

constexpr const char* kSections[] = {"quarters", "representations", "formulas", "maps"};

int write_accuracy_document(const AccuracyDocumentOptions& options);

}  // namespace multum::bench
