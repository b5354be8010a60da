// SPDX-License-Identifier: Apache-2.0
// Makes docs/ACCURACY.md: every figure of it, on the four-quarter map and on the normal maps of a folder.
#pragma once

#include <string>

namespace multum::bench {

struct AccuracyDocumentOptions {
  std::string output;  // Markdown file
  std::string maps;    // folder of real maps; empty: none
  std::string brdfs;   // folder of measured BRDFs; empty: none
  std::string commit;  // named in the document
  int size = 1024;     // side of the four-quarter map
  int threads = 2;
};

int write_accuracy_document(const AccuracyDocumentOptions& options);

}  // namespace multum::bench
