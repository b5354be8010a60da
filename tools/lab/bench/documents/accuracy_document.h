// SPDX-License-Identifier: Apache-2.0
// Writes docs/evidence/ACCURACY.md from measurements on the four-quarter map and on the normal maps of a folder.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

struct AccuracyDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of real maps; no maps if empty
  std::string brdfs;   // folder of measured BRDFs; no BRDFs if empty
  // Sections to make, from kSections. If the list is empty, all sections are made. Other sections of an existing
  // document do not change.
  std::vector<std::string> sections;
  std::string commit;        // commit that the document names
  bool is_quick = false;     // measure only a few settings, to test that the page can be made
  bool allow_dirty = false;  // accept a `commit` with uncommitted changes
  int size = 1024;           // side of the four-quarter map
  int threads = 2;
};

constexpr const char* kSections[] = {"quarters", "representations", "formulas", "maps"};

int write_accuracy_document(const AccuracyDocumentOptions& options);

}  // namespace multum::bench
